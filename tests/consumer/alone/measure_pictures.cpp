// SPDX-License-Identifier: MIT
#include <selvedge/lab/measure_pictures.h>

int main() { return selvedge::draw_spectrum({}).width > 0 ? 0 : 1; }

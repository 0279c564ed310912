// SPDX-License-Identifier: MIT
#include <selvedge/pictures/measure_pictures.h>

int main() { return selvedge::draw_spectrum({}).width > 0 ? 0 : 1; }

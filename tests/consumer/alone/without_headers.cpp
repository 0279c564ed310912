// SPDX-License-Identifier: MIT
// For components that have no public headers, because only others link them.
int main() { return 0; }

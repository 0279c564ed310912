// SPDX-License-Identifier: MIT
// Other components link this one, which has no public headers.
int main() { return 0; }

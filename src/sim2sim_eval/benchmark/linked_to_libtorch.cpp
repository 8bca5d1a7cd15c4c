// SPDX-License-Identifier: BSD-3-Clause
// Does nothing: how long a program takes to start that links what the commands link.
int main() { return 0; }

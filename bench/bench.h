// SPDX-License-Identifier: MIT
#pragma once

namespace selvedge {

// One function for each benchmark of `bench NAME`. It reads its options and returns the exit code;
// main.cpp prints the message of an exception.
int bench_batch(int argc, char** argv);
int bench_bending(int argc, char** argv);
int bench_broadphase(int argc, char** argv);
int bench_core(int argc, char** argv);
int bench_drape(int argc, char** argv);
int bench_drape_split(int argc, char** argv);
int bench_enclosure(int argc, char** argv);
int bench_fail_safe(int argc, char** argv);
int bench_find_collisions(int argc, char** argv);
int bench_grips(int argc, char** argv);
int bench_image_space(int argc, char** argv);
int bench_integrators(int argc, char** argv);
int bench_limiters(int argc, char** argv);
int bench_order_in_contact(int argc, char** argv);
int bench_response(int argc, char** argv);
int bench_rest(int argc, char** argv);
int bench_rivals(int argc, char** argv);
int bench_seams(int argc, char** argv);
int bench_slender(int argc, char** argv);
int bench_untangle(int argc, char** argv);

}  // namespace selvedge

// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/compare/compare_folder.h>

#include <filesystem>

namespace selvedge {

/// Writes a Snakefile [Molder2021] beside the plan, with one job per cell and one job that makes
/// the table and the page. Jobs may run on any machines that share the folder and have the same
/// build.
void write_workflow(const std::filesystem::path& out, const ComparePlan& plan);

}  // namespace selvedge

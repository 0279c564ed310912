// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/compare_folder.h>

#include <filesystem>

namespace selvedge {

/// Writes Snakefile [Molder2021] beside the plan: one job a cell, and one that makes table and page
/// of all. Jobs may run on any machines that share the folder and have the same build.
void write_workflow(const std::filesystem::path& out, const ComparePlan& plan);

}  // namespace selvedge

// SPDX-License-Identifier: MIT
#pragma once

/// Version and licence of this program, and the libraries that it contains with their versions and
/// licences.
const char* version_text();

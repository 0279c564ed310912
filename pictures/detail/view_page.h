// SPDX-License-Identifier: MIT
#pragma once

namespace selvedge::detail {

/// The page without data: %TITLE%, %DATA% and %SCRIPT% stand for what is filled in.
const char* view_page_template();
/// The program of the page.
const char* view_page_script();

}  // namespace selvedge::detail

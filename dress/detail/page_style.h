// SPDX-License-Identifier: MIT
#pragma once

namespace selvedge::detail {

/// What the pages of garments have in common within their heads: encoding, width, colours by day
/// and night, and the body.
inline constexpr const char* kPageStyle = R"(<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
:root { --ink: #1d2129; --soft: #5b6472; --line: #d9dde4; --paper: #ffffff; --good: #1b7f4b; --bad: #c02a2a; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8eaee; --soft: #9aa3b2; --line: #363c47; --paper: #16181d; --good: #4cc38a; --bad: #ff7a70; }
}
body { margin: 0 auto; padding: 1rem; max-width: 72rem; font: 16px/1.45 system-ui, sans-serif; color: var(--ink); background: var(--paper); }
.soft { color: var(--soft); }
</style>
)";

}  // namespace selvedge::detail

// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/internal/material_fields.h>

#include <string>
#include <vector>

namespace selvedge::detail {
namespace {

/// What the key of the laws of a kind refers to.
struct LawTexts {
  template <class Law>
  LawTexts(std::string start, const std::vector<Law>& laws) : text(std::move(start)) {
    for (const Law& law : laws) {
      text += (words.empty() ? ": " : "; ") + law.name + ": " + law.text;
      words.push_back(law.name);
    }
  }
  Key key() const { return {.text = text, .words = Words(words)}; }

  std::string text;
  std::vector<std::string_view> words;
};

/// The bending laws that need rows of particles, and which of them serve cells that are split.
std::string bending_laws_of_grids() {
  std::string all, split;
  for (const BendingLaw& law : fabric_laws().bending) {
    if (law.add_to_triangles != nullptr) continue;
    all += (all.empty() ? "" : ", ") + law.name;
    if (law.add_to_side != nullptr) split += (split.empty() ? "" : ", ") + law.name;
  }
  return all + " (cells that are split: " + split + ")";
}

LawTexts bending_law_texts() {
  LawTexts texts("How cloth resists bending", fabric_laws().bending);
  texts.text += ". Only on grids of cells: " + bending_laws_of_grids() +
                "; the responsive pattern always buckles";
  return texts;
}

}  // namespace

Key stretch_law_key() {
  static const LawTexts texts("How cloth resists stretch", fabric_laws().stretch);
  return texts.key();
}

Key shear_law_key() {
  static const LawTexts texts("How cloth resists shear", fabric_laws().shear);
  return texts.key();
}

Key bending_law_key() {
  static const LawTexts texts = bending_law_texts();
  return texts.key();
}

}  // namespace selvedge::detail

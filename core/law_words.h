// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/fabric.h>

#include <span>
#include <stdexcept>
#include <string>

namespace selvedge {

/// A law and its word in scene files.
template <class Law>
struct LawWord {
  const char* word;
  Law law;
};
/// The words of all laws of a kind.
std::span<const LawWord<StretchLaw>> words_of(StretchLaw);
std::span<const LawWord<ShearLaw>> words_of(ShearLaw);
std::span<const LawWord<BendingLaw>> words_of(BendingLaw);

/// The word of a law.
template <class Law>
const char* law_word(Law law) {
  for (const LawWord<Law>& known : words_of(law))
    if (known.law == law) return known.word;
  throw std::invalid_argument("a law without a word");
}
/// The law of a word; throws std::invalid_argument for another word.
template <class Law>
Law law_of(const std::string& word) {
  for (const LawWord<Law>& known : words_of(Law{}))
    if (word == known.word) return known.law;
  throw std::invalid_argument("there is no law \"" + word + "\"");
}

}  // namespace selvedge

// SPDX-License-Identifier: MIT
//
// What the panels of a pattern are: by words in their names, and by what they are sewn to.
#include <fmt/format.h>
#include <selvedge/dress/internal/arrange.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

using Part = PanelRole::Part;
using Side = PanelRole::Side;
using Face = PanelRole::Face;

struct Word {
  const char* text;
  PanelRole role;
};

constexpr PanelRole of_part(Part part) { return {part, Side::none, Face::none}; }
constexpr PanelRole of_side(Side side) { return {Part::unknown, side, Face::none}; }
constexpr PanelRole of_face(Face face) { return {Part::unknown, Side::none, face}; }

/// Longer words first where one begins with the other.
const std::array kWords = {Word{"waistband", of_part(Part::waistband)},
                           Word{"wristband", of_part(Part::cuff)},
                           Word{"neckband", of_part(Part::collar)},
                           Word{"trousers", of_part(Part::leg)},
                           Word{"trouser", of_part(Part::leg)},
                           Word{"sleeves", of_part(Part::sleeve)},
                           Word{"sleeve", of_part(Part::sleeve)},
                           Word{"bodice", of_part(Part::torso)},
                           Word{"collar", of_part(Part::collar)},
                           Word{"pocket", of_part(Part::patch)},
                           Word{"facing", of_part(Part::patch)},
                           Word{"shorts", of_part(Part::leg)},
                           Word{"jacket", of_part(Part::torso)},
                           Word{"center", {}},
                           Word{"centre", {}},
                           Word{"panel", {}},
                           Word{"skirt", of_part(Part::skirt)},
                           Word{"pants", of_part(Part::leg)},
                           Word{"jeans", of_part(Part::leg)},
                           Word{"torso", of_part(Part::torso)},
                           Word{"shirt", of_part(Part::torso)},
                           Word{"right", of_side(Side::right)},
                           Word{"front", of_face(Face::front)},
                           Word{"upper", of_part(Part::torso)},
                           Word{"patch", of_part(Part::patch)},
                           Word{"pant", of_part(Part::leg)},
                           Word{"left", of_side(Side::left)},
                           Word{"back", of_face(Face::back)},
                           Word{"rear", of_face(Face::back)},
                           Word{"hood", of_part(Part::hood)},
                           Word{"cuff", of_part(Part::cuff)},
                           Word{"band", of_part(Part::waistband)},
                           Word{"belt", of_part(Part::waistband)},
                           Word{"body", of_part(Part::torso)},
                           Word{"yoke", of_part(Part::torso)},
                           Word{"tee", of_part(Part::torso)},
                           Word{"leg", of_part(Part::leg)},
                           Word{"top", of_part(Part::torso)},
                           Word{"arm", of_part(Part::sleeve)},
                           Word{"wb", of_part(Part::waistband)},
                           Word{"up", of_part(Part::torso)},
                           Word{"l", of_side(Side::left)},
                           Word{"r", of_side(Side::right)},
                           Word{"f", of_face(Face::front)},
                           Word{"b", of_face(Face::back)}};

void add_word(const PanelRole& word, PanelRole& role) {
  // "skirt_top" is a skirt: the word for a part that says more wins.
  if (word.part != Part::unknown && (role.part == Part::unknown || role.part == Part::torso))
    role.part = word.part;
  if (word.side != Side::none && role.side == Side::none) role.side = word.side;
  if (word.face != Face::none && role.face == Face::none) role.face = word.face;
}

/// Divides a word such as lfsleeve into known ones; nothing may remain.
bool divide(const std::string& word, PanelRole& role) {
  if (word.empty()) return true;
  for (const Word& known : kWords) {
    const std::string text = known.text;
    if (!word.starts_with(text)) continue;
    PanelRole rest;
    if (!divide(word.substr(text.size()), rest)) continue;
    add_word(known.role, role);
    add_word(rest, role);
    return true;
  }
  return false;
}

/// The words of a name in lower case, divided at capitals and at everything that is no letter.
std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words(1);
  char last = ' ';
  for (const char c : name) {
    const bool is_letter = std::isalpha(static_cast<unsigned char>(c)) != 0;
    const bool is_capital = std::isupper(static_cast<unsigned char>(c)) != 0;
    const bool was_capital = std::isupper(static_cast<unsigned char>(last)) != 0;
    if (!is_letter || (is_capital && !was_capital)) words.emplace_back();
    if (is_letter) words.back() += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    last = c;
  }
  std::erase_if(words, [](const std::string& word) { return word.empty(); });
  return words;
}

/// Edges of panels, and the seams between them.
class Seams {
 public:
  explicit Seams(const SewingPattern& pattern) : pattern_(pattern) {
    for (const PatternPanel& panel : pattern.panels) {
      first_.push_back(count_);
      count_ += static_cast<std::int32_t>(panel.edges.size());
    }
    partner_.assign(count_, {-1, -1});
    for (const PatternStitch& s : pattern.stitches) {
      if (pattern.is_on_a_line(s)) continue;
      partner_[first_[s.a.panel] + s.a.edge] = s.b;
      partner_[first_[s.b.panel] + s.b.edge] = s.a;
    }
  }

  /// The edge to which an edge is sewn; panel -1: none.
  PatternStitch::Side partner(std::int32_t panel, std::int32_t edge) const {
    return partner_[first_[panel] + edge];
  }
  std::int32_t edges(std::int32_t panel) const {
    return static_cast<std::int32_t>(pattern_.panels[panel].edges.size());
  }
  bool are_sewn(std::int32_t a, std::int32_t b) const {
    for (std::int32_t e = 0; e < edges(a); ++e)
      if (partner(a, e).panel == b) return true;
    return false;
  }

  /// Closed lines of edges that are not sewn once all seams are closed.
  int openings() const {
    std::vector<std::int32_t> parent(count_);  // of the corners: edge e starts at corner e
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](std::int32_t v) {
      while (parent[v] != v) v = parent[v] = parent[parent[v]];
      return v;
    };
    const auto join = [&](std::int32_t a, std::int32_t b) { parent[root(a)] = root(b); };
    const auto start = [&](const PatternStitch::Side& s) { return first_[s.panel] + s.edge; };
    const auto end = [&](const PatternStitch::Side& s) {
      return first_[s.panel] + (s.edge + 1) % edges(s.panel);
    };
    for (const PatternStitch& s : pattern_.stitches) {
      if (pattern_.is_on_a_line(s)) continue;
      const bool same = s.direction == PatternStitch::Direction::start_to_start;
      join(start(s.a), same ? start(s.b) : end(s.b));
      join(end(s.a), same ? end(s.b) : start(s.b));
    }
    // Edges that are not sewn join their ends into lines.
    std::vector<std::int32_t> line(count_);
    std::iota(line.begin(), line.end(), 0);
    const auto line_root = [&](std::int32_t v) {
      while (line[v] != v) v = line[v] = line[line[v]];
      return v;
    };
    std::vector<char> is_free(count_, 0);
    for (std::int32_t p = 0; p < static_cast<std::int32_t>(first_.size()); ++p)
      for (std::int32_t e = 0; e < edges(p); ++e) {
        if (partner(p, e).panel >= 0) continue;
        const std::int32_t a = root(start({p, e})), b = root(end({p, e}));
        is_free[a] = is_free[b] = 1;
        line[line_root(a)] = line_root(b);
      }
    int found = 0;
    for (std::int32_t v = 0; v < count_; ++v)
      if (is_free[v] && root(v) == v && line_root(v) == v) ++found;
    return found;
  }

 private:
  const SewingPattern& pattern_;
  std::vector<std::int32_t> first_;
  std::int32_t count_ = 0;
  std::vector<PatternStitch::Side> partner_;
};

class RoleFinder {
 public:
  RoleFinder(const SewingPattern& pattern, std::vector<PanelRole>& roles,
             std::vector<std::string>& why)
      : pattern_(pattern), seams_(pattern), roles_(roles), why_(why) {}

  void find() {
    for (std::int32_t p = 0; p < count(); ++p)
      if (roles_[p].part == Part::unknown && is_on_lines(p))
        give(p, Part::patch, "sewn onto a panel");
    for (int round = 0; round < 4; ++round) {
      for (std::int32_t p = 0; p < count(); ++p) {
        guess_from_seams(p);
        guess_face(p);
        guess_side(p);
      }
      if (round == 0) guess_trunk();
      if (round == 1) guess_first();
    }
    for (std::int32_t p = 0; p < count(); ++p)
      if (roles_[p].part == Part::unknown) give(p, Part::torso, "nothing else fits");
  }

 private:
  std::int32_t count() const { return static_cast<std::int32_t>(roles_.size()); }

  void say(std::int32_t p, const std::string& reason) {
    if (!why_[p].empty()) why_[p] += ", ";
    why_[p] += reason;
  }
  void give(std::int32_t p, Part part, const std::string& reason) {
    roles_[p].part = part;
    say(p, reason);
  }

  bool is_trunk(std::int32_t p) const {
    const Part part = roles_[p].part;
    return part == Part::torso || part == Part::skirt || part == Part::leg;
  }

  /// Height and width of a panel in its file, m.
  Vec2 extent(std::int32_t p) const {
    const std::vector<Vec2>& x = pattern_.panels[p].vertices;
    Vec2 low = x.front(), high = low;
    for (const Vec2& v : x) low = low.cwiseMin(v), high = high.cwiseMax(v);
    return high - low;
  }

  /// It is sewn to lines of other panels and to nothing else.
  bool is_on_lines(std::int32_t p) const {
    bool is_on = false;
    for (const PatternStitch& s : pattern_.stitches) {
      if (s.a.panel != p && s.b.panel != p) continue;
      const PatternStitch::Side& own = s.a.panel == p ? s.a : s.b;
      if (!pattern_.is_on_a_line(s) || pattern_.panels[p].is_line(own.edge)) return false;
      is_on = true;
    }
    return is_on;
  }

  /// Two of its edges are sewn together, and no dart is between them.
  bool is_tube(std::int32_t p) const {
    const std::int32_t n = seams_.edges(p);
    for (std::int32_t e = 0; e < n; ++e) {
      const PatternStitch::Side other = seams_.partner(p, e);
      if (other.panel == p && (other.edge + 1) % n != e && (e + 1) % n != other.edge) return true;
    }
    return false;
  }

  void guess_from_seams(std::int32_t p) {
    if (roles_[p].part != Part::unknown || roles_[p].face != Face::none) return;
    bool to_torso = false, to_sleeve = false, to_other = false;
    for (std::int32_t e = 0; e < seams_.edges(p); ++e) {
      const std::int32_t q = seams_.partner(p, e).panel;
      if (q < 0 || q == p) continue;
      to_torso = to_torso || roles_[q].part == Part::torso;
      to_sleeve = to_sleeve || roles_[q].part == Part::sleeve;
      to_other = to_other || is_trunk(q);
    }
    constexpr double narrow = 3.0;
    const Vec2 size = extent(p);
    if (is_tube(p) && to_sleeve && !to_torso)
      give(p, Part::cuff, "a tube sewn to a sleeve");
    else if (is_tube(p) && to_torso && size.maxCoeff() < narrow * size.minCoeff())
      give(p, Part::sleeve, "a tube sewn to the trunk");
    else if (is_tube(p) && to_other && size.maxCoeff() >= narrow * size.minCoeff())
      give(p, Part::waistband, "a narrow ring sewn to the trunk");
  }

  /// A panel that is sewn to a front more than once is its back, and the other way round.
  void guess_face(std::int32_t p) {
    if (roles_[p].face != Face::none || is_tube(p)) return;
    if (roles_[p].part == Part::hood || roles_[p].part == Part::patch) return;
    std::array<int, 2> seams = {0, 0};
    for (std::int32_t e = 0; e < seams_.edges(p); ++e) {
      const std::int32_t q = seams_.partner(p, e).panel;
      if (q < 0 || q == p || roles_[q].part != roles_[p].part) continue;
      if (roles_[q].face == Face::front) ++seams[0];
      if (roles_[q].face == Face::back) ++seams[1];
    }
    if (roles_[p].side != Side::none && roles_[p].part != Part::sleeve) return;  // of a ring
    if (seams[0] > 1 && seams[1] == 0) {
      roles_[p].face = Face::back;
      say(p, "sewn to a front on both sides");
    } else if (seams[1] > 1 && seams[0] == 0) {
      roles_[p].face = Face::front;
      say(p, "sewn to a back on both sides");
    }
  }

  /// A sleeve or a cuff is on the side of the panels to which it is sewn, if these are of one side.
  void guess_side(std::int32_t p) {
    if (roles_[p].side != Side::none || is_trunk(p)) return;
    if (roles_[p].part != Part::sleeve && roles_[p].part != Part::cuff) return;
    Side side = Side::none;
    for (std::int32_t e = 0; e < seams_.edges(p); ++e) {
      const std::int32_t q = seams_.partner(p, e).panel;
      if (q < 0 || q == p || roles_[q].side == Side::none) continue;
      if (side != Side::none && side != roles_[q].side) return;
      side = roles_[q].side;
    }
    roles_[p].side = side;
  }

  /// Left and right halves that meet at a crotch: the seam to the other half follows a seam to the
  /// panel behind.
  bool has_crotch(std::int32_t p) const {
    if (roles_[p].side == Side::none || roles_[p].face == Face::none) return false;
    const auto is_other_half = [&](std::int32_t q) {
      return q >= 0 && q != p && roles_[q].face == roles_[p].face && roles_[q].side != Side::none &&
             roles_[q].side != roles_[p].side;
    };
    const auto is_behind = [&](std::int32_t q) {
      return q >= 0 && q != p && roles_[q].side == roles_[p].side && roles_[q].face != Face::none &&
             roles_[q].face != roles_[p].face;
    };
    const std::int32_t n = seams_.edges(p);
    for (std::int32_t e = 0; e < n; ++e) {
      const std::int32_t q = seams_.partner(p, e).panel, r = seams_.partner(p, (e + 1) % n).panel;
      if ((is_other_half(q) && is_behind(r)) || (is_behind(q) && is_other_half(r))) return true;
    }
    return false;
  }

  /// Fronts and backs whose names do not say of what.
  void guess_trunk() {
    const int openings = seams_.openings();
    const bool has_torso = std::any_of(roles_.begin(), roles_.end(), [](const PanelRole& r) {
      return r.part == Part::torso || r.part == Part::sleeve || r.part == Part::hood;
    });
    const bool has_lower = std::any_of(roles_.begin(), roles_.end(), [](const PanelRole& r) {
      return r.part == Part::skirt || r.part == Part::leg;
    });
    std::vector<char> crotch;
    for (std::int32_t p = 0; p < count(); ++p) crotch.push_back(has_crotch(p));
    const bool is_ring = openings == 2 || openings == 1;
    for (std::int32_t p = 0; p < count(); ++p) {
      if (roles_[p].part != Part::unknown) continue;
      if (roles_[p].face == Face::none && roles_[p].side == Side::none) continue;
      if (crotch[p])
        give(p, Part::leg, "meets the other half at a crotch");
      else if (has_torso || has_lower)
        give(p, has_torso ? Part::torso : Part::skirt, "the rest of the garment");
      else if (is_ring)
        give(p, Part::skirt, openings == 1 ? "one opening" : "two openings: waist and hem");
      else
        give(p, Part::torso, fmt::format("{} openings: neck, arms and hem", openings));
    }
  }

  /// Names say nothing at all: two panels that are sewn together more than once are front and back.
  /// The neck of the front is cut deeper, so it is the smaller one.
  void guess_first() {
    const bool any = std::any_of(roles_.begin(), roles_.end(), [&](const PanelRole& r) {
      return r.part != Part::waistband && (r.part != Part::unknown || r.face != Face::none);
    });
    if (any) return;
    std::int32_t front = -1, back = -1;
    int most = 1;
    for (std::int32_t p = 0; p < count(); ++p)
      for (std::int32_t q = p + 1; q < count(); ++q) {
        int seams = 0;
        if (roles_[p].part != Part::unknown || roles_[q].part != Part::unknown) continue;
        for (std::int32_t e = 0; e < seams_.edges(p); ++e) seams += seams_.partner(p, e).panel == q;
        if (seams > most) most = seams, front = p, back = q;
      }
    if (front < 0) return;
    const auto area = [&](std::int32_t p) { return std::abs(panel_area(pattern_.panels[p])); };
    if (area(back) < area(front)) std::swap(front, back);
    roles_[front].face = Face::front;
    say(front, "the smaller of two panels that enclose the body");
    roles_[back].face = Face::back;
    say(back, "the larger of two panels that enclose the body");
    guess_trunk();
  }

  const SewingPattern& pattern_;
  Seams seams_;
  std::vector<PanelRole>& roles_;
  std::vector<std::string>& why_;
};

/// The name of a piece of which the panel is one of a pair; else its own.
std::string base_name(const std::string& name) {
  for (const std::string side : {".left", ".right"})
    if (name.ends_with(side)) return name.substr(0, name.size() - side.size());
  return name;
}

}  // namespace

std::string PanelRole::text() const {
  const std::array parts = {"unknown", "torso", "skirt",  "leg",       "sleeve",
                            "cuff",    "hood",  "collar", "waistband", "patch"};
  std::string words = parts[static_cast<std::size_t>(part)];
  if (side != Side::none) words += side == Side::left ? ".left" : ".right";
  if (face != Face::none) words += face == Face::front ? ".front" : ".back";
  return words;
}

PanelRole role_of_name(const std::string& name) {
  PanelRole role;
  for (const std::string& word : words_of(name)) {
    constexpr std::size_t longest = 40;
    PanelRole of_word;
    if (word.size() <= longest && divide(word, of_word)) add_word(of_word, role);
  }
  return role;
}

std::vector<PanelRole> panel_roles(const SewingPattern& pattern, const ArrangeConfig& config,
                                   std::vector<std::string>& why) {
  std::vector<PanelRole> roles;
  why.assign(pattern.panels.size(), "");
  for (const auto& [name, words] : config.table) {
    const bool known = std::any_of(pattern.panels.begin(), pattern.panels.end(),
                                   [&, &wanted = name](const PatternPanel& panel) {
                                     return panel.name == wanted || base_name(panel.name) == wanted;
                                   });
    if (!known)
      throw std::invalid_argument(fmt::format(
          "the table names panel \"{}\", which the pattern does not have; correct the name", name));
    const PanelRole role = role_of_name(words);
    if (role.part == Part::unknown && role.face == Face::none && role.side == Side::none)
      throw std::invalid_argument(
          fmt::format("the table gives panel \"{}\" the place \"{}\"; give words such as front, "
                      "back, sleeve.left, skirt.front, leg.right.back, hood.left, collar, "
                      "waistband, cuff.left or pocket",
                      name, words));
  }
  for (std::size_t p = 0; p < pattern.panels.size(); ++p) {
    const std::string& name = pattern.panels[p].name;
    auto entry = config.table.find(name);
    std::string side;
    if (entry == config.table.end()) {
      entry = config.table.find(base_name(name));
      side = name.substr(base_name(name).size());
    }
    const bool in_table = entry != config.table.end();
    roles.push_back(role_of_name(in_table ? entry->second + side : name));
    const PanelRole& role = roles.back();
    if (role.part != Part::unknown || role.face != Face::none || role.side != Side::none)
      why[p] = in_table ? "table" : "name";
  }
  if (!pattern.stitches.empty()) RoleFinder(pattern, roles, why).find();
  return roles;
}

}  // namespace selvedge

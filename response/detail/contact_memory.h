// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// The forces of the contacts with friction that carried load in the last accepted step. A contact
/// is found again by its vertices; a point of the cloth by its number and the direction of the
/// contact alone, so that it may change to the next triangle.
class ContactMemory {
 public:
  /// A contact of that step.
  struct Past {
    ContactKind kind;
    std::array<std::int32_t, 4> vertex;
    Vec3 normal;
    Vec3 friction;  ///< N, on the first primitive; zero if it slid
    double load;    ///< N
    bool rested;    ///< it did not slide
  };

  /// The contact in that step; null: it carried no load. `particles`: number of particles, which
  /// tells cloth from bodies.
  const Past* find(const ContactPoint& contact, std::size_t particles) const;
  bool empty() const { return past_.empty(); }

  /// Forgets all contacts.
  void clear();
  void add(const Past& past);

  /// Appends the memory, 13 numbers for each contact.
  void save(std::vector<double>& memory) const;
  /// Replaces it. Throws std::invalid_argument if it is none for this number of vertices.
  void restore(std::span<const double> memory, std::size_t vertices);

 private:
  std::vector<Past> past_;
  std::vector<std::int32_t> first_;  // by vertex 0 of the contact: the last added one; -1: none
  std::vector<std::int32_t> next_;   // of each contact: the one of the same vertex before it
};

}  // namespace selvedge::detail

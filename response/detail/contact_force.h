// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/detail/contact_memory.h>
#include <selvedge/response/response.h>

#include <limits>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Options of ContactForce.
struct ContactForceConfig {
  /// Least normal stiffness divided by m_eff/h², dimensionless. A contact that carries q times the
  /// weight of its own particles yields by q·g·h²/normal_ratio: 2.3 µm·q at h = 1/120 s, but by at
  /// most a tenth of its rest gap (pinched cloth: half) if the first guess knows its load. Higher
  /// values make the linear system stiffer; from 1000 on, stacks need many more solves to find
  /// which contacts carry load.
  double normal_ratio = 300.0;
  /// Viscosity c of friction divided by m_eff/h, dimensionless. Friction that is still wrong by df
  /// after the last solve creeps by df/c: with 100, a taut strip around a cylinder creeps by
  /// 1.5 mm/s, with 1000 by 0.01 mm/s. Higher values make the linear system stiffer. Cloth that
  /// bears many times its weight has more: see bearing_stick.
  double stick_ratio = 1000.0;
  /// The same in an impact. The first solves of an impact give far too high loads. Once a stiff
  /// contact sticks under such a load, its friction decreases only slowly: six sheets that landed
  /// together lost all their sideways speed.
  double impact_stick_ratio = 100.0;
  /// A gap below the rest gap recovers by at most this share of the rest gap per step, so that
  /// cloth that starts too close is not ejected.
  double recovery = 0.2;
  /// A contact whose slip over a step is below this share of the rest gap is first treated as
  /// sticking: 3e-4 m/s for 2 mm at 1/120 s.
  double stick_slip = 1.25e-3;
  /// No further solve is requested once the contact forces change by at most this share of the
  /// total load, and friction by at most this share of the sum of all μλ. Higher values are faster,
  /// but single contacts may pull, or friction may be wrong, by that much in a step.
  double load_tolerance = 0.1;
  /// The same where the cloth comes to rest. Loads that are wrong by a tenth leave it unbalanced by
  /// a twentieth of its weight.
  double settled_tolerance = 2e-4;
};

// -- shared by contact_force.cpp and contact_force_guess.cpp ------------------------------------

/// Particles per range of a loop.
inline constexpr std::size_t kContactVertexGrain = 2048;

/// N, load of a contact that takes part in a solve although no load is expected.
inline constexpr double kLeastLoad = std::numeric_limits<double>::min();

/// The greatest factor by which a contact is made stiffer for its load: rest gaps may be tiny, and
/// the solver works in single precision.
inline constexpr double kStiffest = 1e4;

inline Vec3 tangential(const Vec3& u, const Vec3& normal) { return u - normal.dot(u) * normal; }

/// f, shortened to at most `limit`.
inline Vec3 within(const Vec3& f, double limit) {
  const double size = f.norm();
  return size <= limit ? f : Vec3(limit / size * f);
}

/// Contact and Coulomb friction as forces inside the implicit step [after the active-set view of
/// penalty contact, Wriggers 2006, ch. 5]. Each contact pushes with λ = k (rest - gap⁺)₊ along its
/// normal, where gap⁺ is the linearised gap at the end of the step. Friction is an augmented
/// Lagrangian [P. Alart, A. Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991]: against the slip s
/// it is f(s) = f₀ - c s, shortened to μλ, where f₀ is the friction after the solve before, so that
/// a contact sticks without creep at a moderate c. Semismooth Newton iterations solve both: after
/// each solve, `update` finds which contacts carry load and what friction is due, and the caller
/// solves again until nothing changes. The first guess of loads and friction are the forces that
/// balance all others where the cloth keeps its velocities; in an impact, the loads that stop the
/// predicted approach.
///
/// A contact that rested in the last step starts from its friction there, which is then f₀ for the
/// whole step: a tangential spring of stiffness c/h that slides at μλ [CundallStrack1979]. The
/// next step corrects the slip that a solve leaves. If each step guessed friction from nothing,
/// these slips would add up and the cloth would creep.
class ContactForce final : public Response {
 public:
  explicit ContactForce(const ContactForceConfig& config = {}) : config_(config) {}

  void begin(const ResponseStep& step) override;
  void add(std::span<const ContactPoint> contacts) override;
  std::span<const ImplicitTerm> terms() override;
  /// Takes the solved velocities, m/s, and pulls them back to the point of least energy on the line
  /// from the velocities of the previous solve. Returns true if the contact forces at these
  /// velocities differ enough from those of the solve to require another solve.
  bool update(std::span<Vec3> v) override;

  /// Explicit steps only, which have no solve: answers contacts by impulses (`impulse`, without
  /// restitution).
  void correct(std::span<Vec3> x_t1) override;
  /// Removes from the end-of-step velocities the part that comes from opening gaps that were too
  /// small, so that cloth is moved out of a violation without being accelerated. Keeps the linear
  /// momentum of free particles.
  void finish(std::span<Vec3> v) const override;
  void finish_impulses(std::span<const Vec3> v, std::vector<ContactImpulse>& out) const override;
  void accept(std::span<const Vec3> x_t1) override;
  void save_memory(std::vector<double>& memory) const override;
  void restore_memory(std::span<const double> memory, std::size_t vertices) override;
  void impulses(std::span<const Vec3> v, std::vector<ContactImpulse>& out) const override;
  std::string_view substitute() const override { return explicit_ ? "impulse" : ""; }
  ResponseTraits traits() const override;

 private:
  struct Entry {
    ContactPoint point;
    Vec3 body_motion;              // Σ weight·displacement of the body vertices, m
    double target = 0.0;           // m, gap at the end of the step at which it would carry no load
    double stiffness = 0.0;        // N/m
    double stick = 0.0;            // c, kg/s
    double m_eff = 0.0;            // kg, effective inertia of the contact against an impulse
    double free_share = 1.0;       // of the compliance that it would have without held particles
    double approach = 0.0;         // kg·m, m_eff·gap violation without what gravity adds to it
    bool near = false;             // it touches, or does so at the current speed
    double one_sided = 0.0;        // 1: nothing presses its particles from another side; 0 to 1
    double load = 0.0;             // N, last estimate of λ
    double load_before = 0.0;      // N, in the last step
    bool remembers = false;        // it rested in the last step: f₀ is the friction there
    Vec3 friction = Vec3::Zero();  // N, f₀
    Vec3 along = Vec3::Zero();     // unit direction of the friction of a sliding contact
    Vec3 offset = Vec3::Zero();    // N, friction of the next solve at no slip
    double viscosity = 0.0;        // kg/s, of friction: in all directions, or across `along`
    double friction_change = 0.0;  // N, change that the last update asked for
    double limit = 0.0;            // N, the μλ for which friction was set
    Vec3 applied = Vec3::Zero();   // N·s, impulse that holds the cloth at the current velocities
    Vec3 solved = Vec3::Zero();    // N·s, impulse in the last solve
  };
  /// Sums over the contacts of a particle, by their weights.
  struct Yield {
    double load = 0.0, known = 0.0;  // N: guessed, and at least that of the last step
    double stiffness = 0.0;          // N/m
    double weights = 0.0;
    Vec3 direction = Vec3::Zero();  // the same sum over the normals
    void add(const Entry& e, double weight);
    double one_sided() const;
  };
  /// One contact on the line from the velocities of one solve to those of the next.
  struct LineContact {
    const Entry* entry;
    Vec3 velocity_change;                // change of the relative velocity over the whole line, m/s
    double violation, violation_change;  // m, gap violation at the start (target - gap) and its
                                         // change over the line
    Vec3 slip, slip_change;              // m/s, at the start, and its change over the line
  };
  /// Sums over contacts by which an update decides.
  struct Change {
    double force = 0.0;  // N, by how much the forces differ from those of the last solve
    double load = 0.0;   // N
    double friction = 0.0, limit = 0.0;  // N, change of friction, and Σ μλ
    void add(const Change& other);
  };

  Vec3 motion_of(const Entry& e, std::span<const Vec3> v) const;
  double stick_speed(const ContactPoint& c) const;
  double yielding() const;
  double held_compliance(const ContactPoint& c) const;
  double shared_target(const Entry& e) const;
  bool comes_near(const Entry& e) const;
  double first_load(const Entry& e) const;
  void recall(Entry& e) const;
  void press_loads(std::span<Entry> entries);
  std::size_t pressing_body(const ContactPoint& c) const;
  std::size_t first_leader(std::size_t particle) const;
  double pressing_load(const Entry& e) const;
  double bearing_stick(const ContactPoint& c, double load) const;
  void start(Entry& e) const;
  ImplicitTerm term_of(const Entry& e) const;
  bool is_impact() const;
  Vec3 first_friction(const Entry& e) const;
  double first_limit(const Entry& e) const;
  void start_friction(Entry& e) const;
  void set_balanced(const ResponseStep& step);
  void guess_forces(std::span<Entry> entries);
  void guess_force(Entry& e);
  Vec3 guessed_motion(const Entry& e) const;
  void add_guess(const Entry& e, const Vec3& impulse);
  void bear_loads(std::span<Entry> entries, bool rigid);
  double recovered(const ContactPoint& c) const;
  void linearise_friction(Entry& e, const Vec3& s) const;
  double update(Entry& e, std::span<const Vec3> v) const;
  double update_friction(Entry& e, const Vec3& s, bool carried) const;
  template <class Note>
  void finish(std::span<Vec3> v, const Note& note) const;
  template <class Body>
  void for_each_entry(const Body& body);
  void note_solved(std::span<const Vec3> v);
  void find_line_contacts(std::span<const Vec3> v);
  LineContact line_contact(const Entry& e, std::span<const Vec3> v) const;
  double slope(double share) const;
  double least_energy() const;
  void pull_back(std::span<Vec3> v);

  ContactForceConfig config_;
  ContactMotion motion_;
  std::span<const double> mass_;  // kg, of the particles
  // Of this step, which may join two. With the same stiffness in N/m, contacts at rest yield as in
  // one of them. The viscosity grows with the cube of the joined steps: a strip around a cylinder
  // then creeps 3 times as fast as in steps that join none; with the square 5, unchanged 50 times.
  double normal_ratio_ = 0.0;  // normal stiffness divided by m_eff/h²
  double load_tolerance_ = 0.0;
  double stick_scale_ = 1.0;  // viscosity divided by that of a step that joins none
  std::vector<Vec3> body_displacement_, v_start_, v_predicted_;
  std::vector<Vec3> v_guess_;     // of particles on which only these forces and the guess act, m/s;
                                  // empty: the other forces are unknown
  std::vector<Vec3> v_unpushed_;  // the same without the guess, in scenes with rigid bodies
  std::vector<Yield> yields_;     // scratch of the first guess, by particle
  std::vector<Entry> entries_;
  std::vector<ImplicitTerm> terms_;
  std::vector<std::size_t> term_entry_;  // entry of each term
  std::unique_ptr<Response> explicit_;   // answers explicit steps; created when first needed
  int friction_updates_ = 0;             // updates of this step that only friction asked for
  double room_ = 0.0, approach_ = 0.0;   // kg·m: Σ m_eff·rest gap, Σ approach
  std::vector<Vec3> v_last_;  // velocities after the last update; empty: no update in this step yet
  std::vector<LineContact> line_contacts_;
  std::vector<Change> changes_;  // scratch of an update
  ContactMemory memory_;         // of the last accepted step
};

}  // namespace selvedge::detail

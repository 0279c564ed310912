// SPDX-License-Identifier: MIT
// peer_bullet FOLDER: simulates FOLDER/sheet.obj as a soft body of Bullet on the bodies of
// FOLDER/case.txt and writes FOLDER/bullet/*.obj. The settings are those of the cloth in Bullet's
// SoftDemo, with a margin for a sheet of this size and four steps a frame. Bullet tests soft bodies
// against the distance function of a convex shape, so the bodies are its sphere and its box. Those
// that move are kinematic. The human body is a soft body without moving nodes, and Bullet tests the
// vertices of each of both against the faces of the other (VF_SS).
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

constexpr double kMargin = 0.005, kLinear = 0.4, kVoxel = 0.01;
constexpr int kSubsteps = 4, kIterations = 10;

struct Mesh {
  std::vector<btScalar> x;
  std::vector<int> triangles;
};

Mesh read_obj(const std::string& file) {
  Mesh mesh;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    for (int k = 0; k < 3; ++k) {
      double value = 0.0;
      words >> value;
      if (kind == "v") mesh.x.push_back(btScalar(value));
      if (kind == "f") mesh.triangles.push_back(int(value) - 1);
    }
  }
  return mesh;
}

struct Key {
  double time = 0.0;
  btVector3 shift{0, 0, 0};
};

/// A body of the case. `motion`: shifts by time, linear in between.
struct Part {
  std::string shape, mesh;
  btVector3 size{0, 0, 0}, centre{0, 0, 0};
  double degrees = 0.0;  // about y
  std::vector<Key> motion;
};

struct Case {
  double mass = 0.0, friction = 0.0, release = -1.0;
  int frames = 0;
  btVector3 gravity{0, 0, 0};
  std::vector<Part> parts;
  std::vector<int> held;
  std::vector<std::pair<int, double>> loaded;
};

btVector3 read_vector(std::istream& in) {
  double x = 0.0, y = 0.0, z = 0.0;
  in >> x >> y >> z;
  return {btScalar(x), btScalar(y), btScalar(z)};
}

Part read_part(std::istream& words) {
  Part part;
  words >> part.shape >> part.mesh;
  part.size = read_vector(words);
  part.centre = read_vector(words);
  words >> part.degrees;
  return part;
}

Case read_case(const std::string& file) {
  Case c;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "cloth") words >> c.mass >> c.friction >> c.frames;
    if (kind == "gravity") c.gravity = read_vector(words);
    if (kind == "part") c.parts.push_back(read_part(words));
    if (kind == "key") {
      Key key;
      words >> key.time;
      key.shift = read_vector(words);
      c.parts.back().motion.push_back(key);
    }
    if (kind == "held") c.held.push_back(*std::istream_iterator<int>(words));
    if (kind == "loaded") {
      std::pair<int, double> load;
      words >> load.first >> load.second;
      c.loaded.push_back(load);
    }
    if (kind == "release") words >> c.release;
    if (!words) throw std::runtime_error(file + ": cannot read " + line);
  }
  if (c.parts.empty()) throw std::runtime_error(file + " has no body");
  return c;
}

btVector3 shift_at(const std::vector<Key>& motion, double time) {
  if (motion.empty()) return {0, 0, 0};
  for (std::size_t k = 1; k < motion.size(); ++k) {
    const Key &a = motion[k - 1], &b = motion[k];
    if (time < b.time) return a.shift.lerp(b.shift, btScalar((time - a.time) / (b.time - a.time)));
  }
  return motion.back().shift;
}

void write_frame(const std::string& folder, int frame, const btSoftBody& cloth, const Mesh& mesh) {
  char name[32];
  std::snprintf(name, sizeof name, "/frame_%04d.obj", frame);
  std::ofstream out(folder + name);
  out.precision(9);
  for (int i = 0; i < cloth.m_nodes.size(); ++i) {
    const btVector3& x = cloth.m_nodes[i].m_x;
    out << "v " << x.x() << ' ' << x.y() << ' ' << x.z() << '\n';
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    out << "f " << mesh.triangles[t] + 1 << ' ' << mesh.triangles[t + 1] + 1 << ' '
        << mesh.triangles[t + 2] + 1 << '\n';
  if (!out) throw std::runtime_error(folder + name + " cannot be written");
}

/// A body that is not convex: a soft body without moving nodes.
btSoftBody* add_static_mesh(btSoftRigidDynamicsWorld& world, const std::string& file) {
  const Mesh mesh = read_obj(file);
  btSoftBody* body = btSoftBodyHelpers::CreateFromTriMesh(world.getWorldInfo(), mesh.x.data(),
                                                          mesh.triangles.data(),
                                                          int(mesh.triangles.size() / 3), false);
  body->getCollisionShape()->setMargin(btScalar(kMargin));
  for (int i = 0; i < body->m_nodes.size(); ++i) body->setMass(i, 0);
  body->m_cfg.kDF = 1;
  body->m_cfg.collisions = btSoftBody::fCollision::VF_SS;
  world.addSoftBody(body);
  return body;
}

struct Solid {
  std::unique_ptr<btCollisionShape> shape;
  std::unique_ptr<btRigidBody> body;
};

btTransform place_at(const Part& part, double time) {
  const btVector3 at = part.centre + shift_at(part.motion, time);
  return btTransform(btQuaternion({0, 1, 0}, btScalar(part.degrees * M_PI / 180)), at);
}

Solid make_solid(const Part& part) {
  Solid solid;
  if (part.shape == "ball")
    solid.shape = std::make_unique<btSphereShape>(part.size.x());
  else
    solid.shape = std::make_unique<btBoxShape>(part.size / 2);
  // A sphere is its margin.
  solid.shape->setMargin(part.shape == "ball" ? part.size.x() : btScalar(0.001));
  solid.body = std::make_unique<btRigidBody>(
      btRigidBody::btRigidBodyConstructionInfo(0, nullptr, solid.shape.get()));
  solid.body->setWorldTransform(place_at(part, 0.0));
  solid.body->setInterpolationWorldTransform(place_at(part, 0.0));
  solid.body->setFriction(1);  // Bullet multiplies it by the friction of the soft body
  if (!part.motion.empty()) {
    solid.body->setCollisionFlags(solid.body->getCollisionFlags() |
                                  btCollisionObject::CF_KINEMATIC_OBJECT);
    solid.body->setActivationState(DISABLE_DEACTIVATION);
  }
  return solid;
}

btSoftBody* add_cloth(btSoftRigidDynamicsWorld& world, const Mesh& mesh, const Case& c,
                      bool human) {
  btSoftBody* cloth = btSoftBodyHelpers::CreateFromTriMesh(world.getWorldInfo(), mesh.x.data(),
                                                           mesh.triangles.data(),
                                                           int(mesh.triangles.size() / 3), false);
  cloth->getCollisionShape()->setMargin(btScalar(kMargin));
  btSoftBody::Material* material = cloth->appendMaterial();
  material->m_kLST = btScalar(kLinear);
  cloth->generateBendingConstraints(2, material);
  cloth->setTotalMass(btScalar(c.mass));
  for (const auto& [node, load] : c.loaded)
    cloth->setMass(node, cloth->getMass(node) + btScalar(load));
  cloth->m_cfg.kDF = btScalar(c.friction);
  cloth->m_cfg.kKHR = 1;  // hardness of contacts with static bodies; 0.1 lets the sheet sink in
  cloth->m_cfg.piterations = kIterations;
  if (human) cloth->m_cfg.collisions = btSoftBody::fCollision::VF_SS;
  world.addSoftBody(cloth);
  return cloth;
}

void write_report(const std::string& folder, const Case& c, bool human, double seconds) {
  std::ofstream(folder + "/report.json")
      << "{\"program\": \"Bullet " << btGetVersion() / 100 << '.' << btGetVersion() % 100
      << "\", \"seconds\": " << seconds << ", \"settings\": {\"steps_per_frame\": " << kSubsteps
      << ", \"position_iterations\": " << kIterations << ", \"linear_stiffness\": " << kLinear
      << ", \"static_contact_hardness\": 1, \"margin_m\": " << kMargin
      << ", \"distance_voxel_m\": " << kVoxel << ", \"friction\": " << c.friction
      << ", \"collisions\": \""
      << (human ? "VF_SS: vertices against faces" : "SDF_RS: nodes against bodies")
      << "; no self-collision\"}}\n";
}

/// Steps through the frames and writes them. Returns processor seconds.
double simulate(btSoftRigidDynamicsWorld& world, btSoftBody& cloth, const Case& c,
                const std::vector<Solid>& solids, const std::function<void(int)>& write) {
  std::vector<btScalar> masses;
  for (const int i : c.held) {
    masses.push_back(cloth.getMass(i));
    cloth.setMass(i, 0);
  }
  write(0);
  double seconds = 0.0;
  const double step = 1.0 / 60 / kSubsteps;
  for (int frame = 1, done = 0; frame <= c.frames; ++frame) {
    const std::clock_t start = std::clock();
    for (int k = 0; k < kSubsteps; ++k, ++done) {
      if (c.release >= 0.0 && done == int(std::ceil(c.release / step)))
        for (std::size_t i = 0; i < masses.size(); ++i) cloth.setMass(c.held[i], masses[i]);
      for (std::size_t i = 0; i < solids.size(); ++i)
        if (!c.parts[i].motion.empty())
          solids[i].body->setWorldTransform(place_at(c.parts[i], (done + 1) * step));
      world.stepSimulation(btScalar(step), 1, btScalar(step));
      world.getWorldInfo().m_sparsesdf.GarbageCollect();
    }
    seconds += double(std::clock() - start) / CLOCKS_PER_SEC;
    write(frame);
  }
  return seconds;
}

void run(const std::string& folder) {
  const Case c = read_case(folder + "/case.txt");
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broad_phase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world(&dispatcher, &broad_phase, &solver, &configuration);
  world.setGravity(c.gravity);
  world.getWorldInfo().m_gravity = world.getGravity();
  world.getWorldInfo().m_sparsesdf.Initialize();
  world.getWorldInfo().m_sparsesdf.setDefaultVoxelsz(btScalar(kVoxel));
  world.getWorldInfo().m_sparsesdf.Reset();  // until then the voxels have 0.25 m and nodes sink in

  btSoftBody* human = nullptr;
  std::vector<Solid> solids;
  for (const Part& part : c.parts) {
    if (part.shape == "mesh") {
      human = add_static_mesh(world, folder + "/" + part.mesh);
    } else {
      solids.push_back(make_solid(part));
      world.addRigidBody(solids.back().body.get());
    }
  }
  const Mesh mesh = read_obj(folder + "/sheet.obj");
  btSoftBody* cloth = add_cloth(world, mesh, c, human != nullptr);
  const std::string out = folder + "/bullet";
  const double seconds =
      simulate(world, *cloth, c, solids, [&](int frame) { write_frame(out, frame, *cloth, mesh); });
  write_report(out, c, human != nullptr, seconds);
  for (btSoftBody* soft : {cloth, human}) {
    if (soft) world.removeSoftBody(soft);
    delete soft;
  }
  for (const Solid& solid : solids) world.removeRigidBody(solid.body.get());
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw std::runtime_error("usage: peer_bullet FOLDER");
    std::filesystem::remove_all(std::string(argv[1]) + "/bullet");
    std::filesystem::create_directories(std::string(argv[1]) + "/bullet");
    run(argv[1]);
  } catch (const std::exception& e) {
    std::cerr << e.what() << '\n';
    return 1;
  }
}

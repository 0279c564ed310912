// SPDX-License-Identifier: MIT
// peer_bullet FOLDER ball|edge|incline|body CELLS FRAMES: simulates FOLDER/sheet.obj as a soft body
// of Bullet on the body of the case and writes FOLDER/bullet/*.obj. The settings are those of the
// cloth in Bullet's SoftDemo, with a margin for a sheet of this size and four steps a frame. Bullet
// tests soft bodies against the distance function of a convex shape, so the bodies are its sphere
// and its box. The human body is a soft body without moving nodes, and Bullet tests the vertices of
// each of both against the faces of the other (VF_SS).
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

namespace {

constexpr double kSize = 0.6, kDensity = 0.15, kFriction = 0.3, kMargin = 0.005, kLinear = 0.4,
                 kVoxel = 0.01;
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

void run(const std::string& folder, const std::string& scene, int frames) {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broad_phase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world(&dispatcher, &broad_phase, &solver, &configuration);
  world.setGravity({0, 0, btScalar(-9.81)});
  world.getWorldInfo().m_gravity = world.getGravity();
  world.getWorldInfo().m_sparsesdf.Initialize();
  world.getWorldInfo().m_sparsesdf.setDefaultVoxelsz(btScalar(kVoxel));
  world.getWorldInfo().m_sparsesdf.Reset();  // until then the voxels have 0.25 m and nodes sink in

  btSphereShape ball(btScalar(0.15));
  btBoxShape box({btScalar(0.15), btScalar(0.45), btScalar(0.15)}),
      slope({2, btScalar(0.5), btScalar(0.1)});
  btCollisionShape* shape = &ball;
  btTransform place = btTransform::getIdentity();
  if (scene == "edge" || scene == "incline") {
    shape = scene == "edge" ? &box : &slope;
    place.setRotation(
        btQuaternion({0, 1, 0}, btScalar((scene == "edge" ? 45.0 : 30.0) * M_PI / 180)));
  }
  shape->setMargin(btScalar(scene == "ball" ? 0.15 : 0.001));  // a sphere is its margin
  btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, shape));
  body.setWorldTransform(place);
  body.setFriction(1);  // Bullet multiplies it by the friction of the soft body
  if (scene != "body") world.addRigidBody(&body);

  const Mesh mesh = read_obj(folder + "/sheet.obj");
  btSoftBody* cloth = btSoftBodyHelpers::CreateFromTriMesh(world.getWorldInfo(), mesh.x.data(),
                                                           mesh.triangles.data(),
                                                           int(mesh.triangles.size() / 3), false);
  cloth->getCollisionShape()->setMargin(btScalar(kMargin));
  btSoftBody::Material* material = cloth->appendMaterial();
  material->m_kLST = btScalar(kLinear);
  cloth->generateBendingConstraints(2, material);
  cloth->setTotalMass(btScalar(kDensity * kSize * kSize));
  cloth->m_cfg.kDF = btScalar(kFriction);
  cloth->m_cfg.kKHR = 1;  // hardness of contacts with static bodies; 0.1 lets the sheet sink in
  cloth->m_cfg.piterations = kIterations;
  btSoftBody* human = scene == "body" ? add_static_mesh(world, folder + "/body.obj") : nullptr;
  if (human) cloth->m_cfg.collisions = btSoftBody::fCollision::VF_SS;
  world.addSoftBody(cloth);

  const std::string out = folder + "/bullet";
  write_frame(out, 0, *cloth, mesh);
  double seconds = 0.0;
  for (int frame = 1; frame <= frames; ++frame) {
    const std::clock_t start = std::clock();
    const btScalar step = btScalar(1.0 / 60 / kSubsteps);
    for (int k = 0; k < kSubsteps; ++k) {
      world.stepSimulation(step, 1, step);
      world.getWorldInfo().m_sparsesdf.GarbageCollect();
    }
    seconds += double(std::clock() - start) / CLOCKS_PER_SEC;
    write_frame(out, frame, *cloth, mesh);
  }
  std::ofstream(out + "/report.json")
      << "{\"program\": \"Bullet " << btGetVersion() / 100 << '.' << btGetVersion() % 100
      << "\", \"seconds\": " << seconds << ", \"settings\": {\"steps_per_frame\": " << kSubsteps
      << ", \"position_iterations\": " << kIterations << ", \"linear_stiffness\": " << kLinear
      << ", \"static_contact_hardness\": 1, \"margin_m\": " << kMargin
      << ", \"distance_voxel_m\": " << kVoxel << ", \"friction\": " << kFriction
      << ", \"collisions\": \""
      << (human ? "VF_SS: vertices against faces" : "SDF_RS: nodes against bodies")
      << "; no self-collision\"}}\n";
  world.removeSoftBody(cloth);
  delete cloth;
  if (human) {
    world.removeSoftBody(human);
    delete human;
  } else {
    world.removeRigidBody(&body);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 5)
      throw std::runtime_error("usage: peer_bullet FOLDER ball|edge|incline|body CELLS FRAMES");
    std::filesystem::remove_all(std::string(argv[1]) + "/bullet");
    std::filesystem::create_directories(std::string(argv[1]) + "/bullet");
    run(argv[1], argv[2], std::atoi(argv[4]));
  } catch (const std::exception& e) {
    std::cerr << e.what() << '\n';
    return 1;
  }
}

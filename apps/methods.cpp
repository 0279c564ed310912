// SPDX-License-Identifier: MIT
#include <selvedge/apps/methods.h>

#if SELVEDGE_HAS_BROADPHASE_CGAL
#include <selvedge/broadphase/adapter_cgal.h>
#endif
#if SELVEDGE_HAS_BROADPHASE_EMBREE
#include <selvedge/broadphase/adapter_embree.h>
#endif
#if SELVEDGE_HAS_BROADPHASE_FCL
#include <selvedge/broadphase/adapter_fcl.h>
#endif
#if SELVEDGE_HAS_BROADPHASE_OSMESA
#include <selvedge/broadphase/image_space.h>
#endif
#if SELVEDGE_HAS_NARROWPHASE_FCL
#include <selvedge/narrowphase/adapter_fcl.h>
#endif
#if SELVEDGE_HAS_NARROWPHASE_LIBCCD
#include <selvedge/narrowphase/adapter_libccd.h>
#endif

selvedge::Methods methods_of_this_build() {
  selvedge::Methods methods;
#if SELVEDGE_HAS_BROADPHASE_CGAL
  selvedge::register_cgal(methods.broad_phases);
#endif
#if SELVEDGE_HAS_BROADPHASE_EMBREE
  selvedge::register_embree(methods.broad_phases);
#endif
#if SELVEDGE_HAS_BROADPHASE_FCL
  selvedge::register_fcl(methods.broad_phases);
#endif
#if SELVEDGE_HAS_BROADPHASE_OSMESA
  selvedge::register_image_space(methods.broad_phases);
#endif
#if SELVEDGE_HAS_NARROWPHASE_FCL
  selvedge::register_fcl(methods.narrow_phases);
#endif
#if SELVEDGE_HAS_NARROWPHASE_LIBCCD
  selvedge::register_libccd(methods.narrow_phases);
#endif
  return methods;
}

std::vector<AdapterMethod> adapter_methods() {
  return {{"broad_phase", "cgal_aabb_tree", "CGAL"},
          {"broad_phase", "cgal_box_intersection", "CGAL"},
          {"broad_phase", "embree_collide", "Embree 3"},
          {"broad_phase", "fcl_dynamic_aabb_tree", "FCL"},
          {"broad_phase", "image_space", "OSMesa"},
          {"narrow_phase", "fcl_vertex_face_edge_edge", "FCL"},
          {"narrow_phase", "libccd_gjk", "libccd"},
          {"narrow_phase", "libccd_mpr", "libccd"}};
}

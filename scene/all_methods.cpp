// SPDX-License-Identifier: MIT
#include <selvedge/scene/all_methods.h>

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

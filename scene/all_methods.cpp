// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/adapters.h>
#include <selvedge/narrowphase/adapters.h>
#include <selvedge/scene/methods.h>

#if SELVEDGE_HAS_BROADPHASE_OSMESA
#include <selvedge/broadphase/image_space/image_space.h>
#endif

namespace selvedge {

Methods methods_of_this_build() {
  Methods methods;
#if SELVEDGE_HAS_BROADPHASE_CGAL
  register_cgal(methods.broad_phases);
#endif
#if SELVEDGE_HAS_BROADPHASE_EMBREE
  register_embree(methods.broad_phases);
#endif
#if SELVEDGE_HAS_BROADPHASE_FCL
  register_fcl(methods.broad_phases);
#endif
#if SELVEDGE_HAS_BROADPHASE_OSMESA
  register_image_space(methods.broad_phases);
#endif
#if SELVEDGE_HAS_NARROWPHASE_FCL
  register_fcl(methods.narrow_phases);
#endif
#if SELVEDGE_HAS_NARROWPHASE_LIBCCD
  register_libccd(methods.narrow_phases);
#endif
  return methods;
}

}  // namespace selvedge

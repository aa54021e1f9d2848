#ifndef ARBORSLAM_CORE_FREED_MEMORY_H_
#define ARBORSLAM_CORE_FREED_MEMORY_H_

#include <malloc.h>

namespace arborslam {

/// Makes glibc keep memory that was freed for what comes next, instead of returning every large block to the system
/// and having it cleared anew: maps are searched in pyramids of some megabytes that live for milliseconds, and building
/// one takes a tenth of the time. For the start of a program; of what others allocate it holds too.
inline void KeepFreedMemory() {
  constexpr int kMebibyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMebibyte);
  mallopt(M_TRIM_THRESHOLD, 256 * kMebibyte);
}

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_FREED_MEMORY_H_

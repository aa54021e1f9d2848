#ifndef ARBORSLAM_CORE_CPU_CLONES_H_
#define ARBORSLAM_CORE_CPU_CLONES_H_

/// Before the definition of a function whose loops the compiler vectorises: it is compiled for x86 processors with AVX2
/// too, and the program takes that version where the processor has it. The results are the same bits: wider registers
/// change no operation, and multiplications and additions are not fused (see CMakeLists.txt). Elsewhere, and under the
/// sanitizers, which do not work with functions that are chosen at the start, it stands for nothing.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define ARBORSLAM_CPU_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define ARBORSLAM_CPU_CLONES
#endif

#endif  // ARBORSLAM_CORE_CPU_CLONES_H_

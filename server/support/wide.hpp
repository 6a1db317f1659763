#pragma once

/// A function of which the compiler makes a second version for processors with AVX2, with loops twice as wide. Results
/// are the same, since AVX2 has no fused operations.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__)
#define HEADFRAME_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define HEADFRAME_WIDE
#endif

/// Before an innermost loop whose steps touch different memory, which the compiler cannot see: or it does not vectorise
/// the loop where many pointers are involved.
#if defined(__GNUC__) && !defined(__clang__)
#define HEADFRAME_INDEPENDENT _Pragma("GCC ivdep")
#else
#define HEADFRAME_INDEPENDENT
#endif

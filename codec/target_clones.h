#pragma once

/// Before a function: compiled once for the machine's baseline and once for AVX2; the loader chooses. Not under
/// ThreadSanitizer, which is not ready yet when the loader does.
#ifdef __SANITIZE_THREAD__
#define TINTREE_CLONES
#else
#define TINTREE_CLONES __attribute__((target_clones("avx2", "default")))
#endif

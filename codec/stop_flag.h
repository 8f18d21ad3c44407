#pragma once

#include <atomic>

namespace tintree {

/// Set from outside, by a signal handler or another thread, to ask for a stop. Long work takes a pointer to one,
/// null for "never", looks at it every few milliseconds and then fails with ErrorCode::kStopped.
using StopFlag = std::atomic<bool>;
static_assert(StopFlag::is_always_lock_free, "a signal handler sets it");

inline bool is_set(const StopFlag* stop) { return stop != nullptr && stop->load(std::memory_order_relaxed); }

}  // namespace tintree

#ifndef ARBORSLAM_CORE_PARALLEL_H_
#define ARBORSLAM_CORE_PARALLEL_H_

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace arborslam {

/// Calls `work(i)` once for every i in [0, count), on `num_threads` threads, in no particular order, and returns when
/// all calls have. Results are the same for any number of threads when each call writes only to what belongs to its i.
/// `work` must not throw.
template <class Work>
void ParallelFor(size_t count, int num_threads, const Work& work) {
  std::atomic<size_t> next{0};
  const auto run = [&] {
    for (size_t i = next++; i < count; i = next++) work(i);
  };
  std::vector<std::thread> helpers;
  for (int i = 1; i < num_threads; ++i) helpers.emplace_back(run);
  run();
  for (std::thread& helper : helpers) helper.join();
}

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_PARALLEL_H_

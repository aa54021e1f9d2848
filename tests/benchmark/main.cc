#include <benchmark/benchmark.h>

#include "core/freed_memory.h"

int main(int argc, char** argv) {
  arborslam::KeepFreedMemory();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

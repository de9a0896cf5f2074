#include "server/bench_rows.hpp"

namespace fanlight {

namespace {

// The paper's own method, after pass 0: detector over 8 samples, first crossing, moving average, no shadow.
#define FANLIGHT_PAPER                                                                                \
  "detector.window=8 detector.place=first-crossing filter.kind=mean filter.islands=1 filter.holes=1 " \
  "light.normals=three-neighbours "

constexpr BenchRow kRows[] = {
    {"r1/paper", "phantom:", 512, FANLIGHT_PAPER "filter.size=7 shadow.coefficient=1"},
    {"r1/paper/31", "phantom:", 512, FANLIGHT_PAPER "filter.size=31 shadow.coefficient=1"},
    {"r1/paper/shadow", "phantom:", 512, FANLIGHT_PAPER "filter.size=7"},
    {"r1/paper/raw", "phantom:", 512,
     FANLIGHT_PAPER "filter.size=7 shadow.coefficient=1 speckle.filter=none"},
    {"r1/quiet", "phantom:speckle=off", 512,
     FANLIGHT_PAPER "filter.size=7 shadow.coefficient=1 speckle.filter=none"},
    {"r1/default", "phantom:", 512, ""},
    {"r1/default/no-shadow", "phantom:", 512, "shadow.coefficient=1"},
    {"r1/volume", "phantom:", 512, "mode=volume"},
    {"r1/perspective", "phantom:", 512, "camera.projection=perspective"},
    {"r1/coarse", "phantom:", 256, FANLIGHT_PAPER "filter.size=7 shadow.coefficient=1 rays.step_mm=0.66"},
    {"picture/256", "phantom:", 256, ""},
    {"picture/1024", "phantom:", 1024, ""},
    {"frames/70", "phantom:frames=70", 512, FANLIGHT_PAPER "filter.size=7 shadow.coefficient=1"},
    {"frames/140", "phantom:frames=140", 512, FANLIGHT_PAPER "filter.size=7 shadow.coefficient=1"},
    {"pixels/256", "phantom:columns=256,rows=256", 512, FANLIGHT_PAPER "filter.size=7 shadow.coefficient=1"},
    {"pixels/1024", "phantom:columns=1024,rows=1024", 512,
     FANLIGHT_PAPER "filter.size=7 shadow.coefficient=1"},
    {"voxels/8", "phantom:columns=1024,rows=1024,frames=70", 512,
     FANLIGHT_PAPER "filter.size=7 shadow.coefficient=1"},
};
#undef FANLIGHT_PAPER

}  // namespace

std::span<const BenchRow> bench_rows() {
  return kRows;
}

}  // namespace fanlight

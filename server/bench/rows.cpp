// SPDX-License-Identifier: Apache-2.0
#include "server/bench/rows.hpp"

namespace fanlight {

namespace {

// The method of the paper, after pass 0: detector over 8 samples, first crossing, moving average, no shadow.
// With fixed numbers, and on frames without log compression.
constexpr std::string_view kPaper =
    "speckle.size=7 speckle.noise=0.52 detector.threshold=20 detector.window=8 detector.place=first-crossing "
    "detector.frame_steps=kept filter.kind=mean filter.size=7 filter.islands=1 "
    "filter.holes=1 light.normals=three-neighbours shadow.coefficient=1";
constexpr std::string_view kDefault;

// The reference work R1 of all earlier figures. A macro, since only literals are joined.
#define FANLIGHT_R1 "phantom:scene=relief,probe=r1"

constexpr BenchRow kRows[] = {
    {"r1/paper", FANLIGHT_R1 ",compression=linear", 512, kPaper, ""},
    {"r1/paper/31", FANLIGHT_R1 ",compression=linear", 512, kPaper, "filter.size=31"},
    {"r1/paper/shadow", FANLIGHT_R1 ",compression=linear", 512, kPaper, "shadow.coefficient=0.3"},
    {"r1/paper/raw", FANLIGHT_R1 ",compression=linear", 512, kPaper, "speckle.filter=none"},
    {"r1/quiet", FANLIGHT_R1 ",compression=linear,speckle=off", 512, kPaper, "speckle.filter=none"},
    {"r1/default", FANLIGHT_R1, 512, kDefault, ""},
    {"r1/default/no-shadow", FANLIGHT_R1, 512, kDefault, "shadow.coefficient=1"},
    {"r1/volume", FANLIGHT_R1, 512, kDefault, "mode=volume"},
    {"r1/perspective", FANLIGHT_R1, 512, kDefault, "camera.projection=perspective"},
    {"r1/coarse", FANLIGHT_R1 ",compression=linear", 256, kPaper, "rays.step_mm=0.66"},
    {"picture/256", FANLIGHT_R1, 256, kDefault, ""},
    {"picture/1024", FANLIGHT_R1, 1024, kDefault, ""},
    {"picture/2880", FANLIGHT_R1, 2880, kDefault, ""},  // as many pixels as 3840 x 2160
    {"frames/70", FANLIGHT_R1 ",compression=linear,frames=70", 512, kPaper, ""},
    {"frames/140", FANLIGHT_R1 ",compression=linear,frames=140", 512, kPaper, ""},
    {"pixels/256", FANLIGHT_R1 ",compression=linear,columns=256,rows=256", 512, kPaper, ""},
    {"pixels/1024", FANLIGHT_R1 ",compression=linear,columns=1024,rows=1024", 512, kPaper, ""},
    {"r2/face", "phantom:scene=womb", 512, kDefault, ""},
    {"voxels/8", FANLIGHT_R1 ",compression=linear,columns=1024,rows=1024,frames=70", 512, kPaper, ""},
};
#undef FANLIGHT_R1

}  // namespace

std::span<const BenchRow> bench_rows() {
  return kRows;
}

}  // namespace fanlight

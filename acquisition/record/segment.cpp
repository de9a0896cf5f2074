// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/segment.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <set>
#include <type_traits>
#include <utility>

#include "acquisition/source/printable.hpp"
#include "proto/base/crc32c.hpp"
#include "proto/base/file_replacement.hpp"
#include "proto/base/printable.hpp"

namespace fanlight {

namespace {

static_assert(std::endian::native == std::endian::little, "records are little endian");

constexpr std::string_view kMagic = "Fanlight segment 1\n";
constexpr std::size_t kLongestSource = 4096;
constexpr std::uint64_t kMostFrames = 1'000'000;
constexpr std::int64_t kLargestUtcS = 253'402'300'799;  // the end of the year 9999

/// The record of one frame as it stands in the file.
struct FrameRecord {
  std::uint64_t sequence;
  std::uint64_t volume_index;
  std::int64_t capture_time_ns;
  double angle_rad;
  std::uint32_t frame_index;
  std::uint32_t frames_in_sweep;
  std::uint32_t pixels_crc;
  std::uint8_t backward;
  std::uint8_t fault;
  std::uint8_t after_interruption;
  std::uint8_t zero;
  std::uint32_t number;  ///< of the frame in the segment
  std::uint32_t crc;     ///< of all before
};
static_assert(sizeof(FrameRecord) == 56 && std::has_unique_object_representations_v<std::uint32_t>);

constexpr std::uint32_t kCountsVolumes = 1;
constexpr std::uint32_t kSimulated = 2;
// Absent in segments of earlier versions, whose frames have no unscanned pixels and known beams.
constexpr std::uint32_t kZeroIsUnscanned = 4;
constexpr std::uint32_t kUnknownBeams = 8;

/// The facts as they stand in the file, before the source's name.
struct FactsRecord {
  double pixel_width_mm, pixel_height_mm, face_column, face_row, motor_radius_mm, probe_radius_mm,
      line_pitch_deg, half_angle_deg, reach_mm, first_angle_rad, last_angle_rad;
  std::int64_t begun_utc_s;
  std::uint32_t kind, columns, rows, flags, frames_per_volume, usual_frames, source_bytes;
  std::uint32_t crc;  ///< of all before, and of the name
};
static_assert(sizeof(FactsRecord) == 12 * 8 + 8 * 4);

template <typename Record>
std::span<const std::uint8_t> before_crc(const Record& record) {
  return {reinterpret_cast<const std::uint8_t*>(&record), offsetof(Record, crc)};
}

template <typename Record>
std::string_view bytes_of(const Record& record) {
  return {reinterpret_cast<const char*>(&record), sizeof record};
}

std::uint32_t facts_crc(const FactsRecord& record, std::string_view source) {
  Crc32c crc;
  crc.add(before_crc(record));
  crc.add({reinterpret_cast<const std::uint8_t*>(source.data()), source.size()});
  return crc.value();
}

std::string facts_text(const RecordingFacts& facts) {
  const FanGeometry& geometry = facts.geometry;
  const std::string source = facts.source.substr(0, kLongestSource);
  FactsRecord record{.pixel_width_mm = geometry.pixel_width_mm,
                     .pixel_height_mm = geometry.pixel_height_mm,
                     .face_column = geometry.face_column,
                     .face_row = geometry.face_row,
                     .motor_radius_mm = geometry.motor_radius_mm,
                     .probe_radius_mm = geometry.probe_radius_mm,
                     .line_pitch_deg = geometry.line_pitch_deg,
                     .half_angle_deg = geometry.sector.half_angle_deg,
                     .reach_mm = geometry.sector.reach_mm,
                     .first_angle_rad = facts.first_angle_rad,
                     .last_angle_rad = facts.last_angle_rad,
                     .begun_utc_s = facts.begun_utc_s,
                     .kind = static_cast<std::uint32_t>(geometry.kind),
                     .columns = geometry.columns,
                     .rows = geometry.rows,
                     .flags = (facts.counts_volumes ? kCountsVolumes : 0U) |
                              (facts.simulated ? kSimulated : 0U) |
                              (geometry.zero_is_unscanned ? kZeroIsUnscanned : 0U) |
                              (geometry.unknown_beams ? kUnknownBeams : 0U),
                     .frames_per_volume = facts.frames_per_volume,
                     .usual_frames = facts.usual_frames,
                     .source_bytes = static_cast<std::uint32_t>(source.size()),
                     .crc = 0};
  record.crc = facts_crc(record, source);
  return std::string(kMagic) + std::string(bytes_of(record)) + source;
}

FrameRecord record_of(const RecordedFrame& frame, std::uint64_t number, std::uint32_t pixels_crc) {
  const FrameStamp& stamp = frame.stamp;
  FrameRecord record{
      .sequence = stamp.sequence,
      .volume_index = stamp.volume_index,
      .capture_time_ns = stamp.capture_time_ns,
      .angle_rad = stamp.angle_rad,
      .frame_index = stamp.frame_index,
      .frames_in_sweep = stamp.frames_in_sweep,
      .pixels_crc = pixels_crc,
      .backward = static_cast<std::uint8_t>(stamp.direction == SweepDirection::kBackward ? 1 : 0),
      .fault = static_cast<std::uint8_t>(frame.fault),
      .after_interruption = static_cast<std::uint8_t>(stamp.after_interruption ? 1 : 0),
      .zero = 0,
      .number = static_cast<std::uint32_t>(number),
      .crc = 0};
  record.crc = crc32c(before_crc(record));
  return record;
}

RecordedFrame frame_of(const FrameRecord& record) {
  return {.stamp = {.sequence = record.sequence,
                    .volume_index = record.volume_index,
                    .frame_index = record.frame_index,
                    .frames_in_sweep = record.frames_in_sweep,
                    .direction = record.backward != 0 ? SweepDirection::kBackward : SweepDirection::kForward,
                    .angle_rad = record.angle_rad,
                    .after_interruption = record.after_interruption != 0,
                    .capture_time_ns = record.capture_time_ns},
          .fault = static_cast<FrameFault>(record.fault)};
}

bool plausible(const FrameRecord& record, std::uint64_t number) {
  return record.crc == crc32c(before_crc(record)) && record.number == number &&
         record.fault <= static_cast<std::uint8_t>(FrameFault::kMisfit);
}

/// Writes the bytes at the end of the file; takes back what was written of them where there is no room for
/// all. Returns 0 or the errno.
int append_whole(int file, std::uint64_t end, std::string_view bytes) {
  const int failure = write_all(file, bytes);
  if (failure == 0) return 0;
  // What is left behind the end is written over or ignored.
  if (ftruncate(file, static_cast<off_t>(end)) == 0) lseek(file, static_cast<off_t>(end), SEEK_SET);
  return failure;
}

std::uint64_t size_of(int file) {
  struct stat status {};
  return fstat(file, &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
}

bool read_whole(int file, void* to, std::size_t bytes) {
  auto* at = static_cast<char*>(to);
  while (bytes > 0) {
    const ssize_t got = read(file, at, bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

Error no_segment(const std::filesystem::path& path) {
  return {ErrorCode::kBadInput,
          fmt::format("{}: this is no part of a recording, expected one that fanlight record wrote",
                      shown(path))};
}

Result<RecordingFacts> read_facts(int file, const std::filesystem::path& path) {
  std::string magic(kMagic.size(), '\0');
  FactsRecord record{};
  if (!read_whole(file, magic.data(), magic.size()) || magic != kMagic ||
      !read_whole(file, &record, sizeof record) || record.source_bytes > kLongestSource) {
    return no_segment(path);
  }
  std::string source(record.source_bytes, '\0');
  if (!read_whole(file, source.data(), source.size()) || record.crc != facts_crc(record, source) ||
      record.kind >= kFrameKindNames.size()) {
    return no_segment(path);
  }
  const RecordingFacts facts{
      .source = source,
      .geometry = {.kind = static_cast<FrameKind>(record.kind),
                   .columns = record.columns,
                   .rows = record.rows,
                   .pixel_width_mm = record.pixel_width_mm,
                   .pixel_height_mm = record.pixel_height_mm,
                   .face_column = record.face_column,
                   .face_row = record.face_row,
                   .motor_radius_mm = record.motor_radius_mm,
                   .probe_radius_mm = record.probe_radius_mm,
                   .line_pitch_deg = record.line_pitch_deg,
                   .sector = {.half_angle_deg = record.half_angle_deg, .reach_mm = record.reach_mm},
                   .zero_is_unscanned = (record.flags & kZeroIsUnscanned) != 0,
                   .unknown_beams = (record.flags & kUnknownBeams) != 0},
      .counts_volumes = (record.flags & kCountsVolumes) != 0,
      .frames_per_volume = record.frames_per_volume,
      .usual_frames = record.usual_frames,
      .simulated = (record.flags & kSimulated) != 0,
      .first_angle_rad = record.first_angle_rad,
      .last_angle_rad = record.last_angle_rad,
      .begun_utc_s = record.begun_utc_s};
  // It goes into the text of a header.
  const bool told = is_printable(facts.source) && std::isfinite(facts.first_angle_rad) &&
                    std::isfinite(facts.last_angle_rad) && facts.begun_utc_s >= 0 &&
                    facts.begun_utc_s <= kLargestUtcS;
  if (!told || !check(facts.geometry)) return no_segment(path);
  return facts;
}

}  // namespace

Result<SegmentWriter> SegmentWriter::create(const SegmentPaths& paths, const RecordingFacts& facts) {
  SegmentWriter writer;
  writer.paths_ = paths;
  writer.frames_file_ = OwnedFile(paths.frames, O_RDWR | O_CREAT | O_EXCL);
  if (!writer.frames_file_.is_open()) return writer.failed(paths.frames, errno);
  writer.pixels_file_ = OwnedFile(paths.pixels, O_RDWR | O_CREAT | O_EXCL);
  if (!writer.pixels_file_.is_open()) {
    const Error error = writer.failed(paths.pixels, errno);
    unlink(paths.frames.c_str());
    return error;
  }
  writer.frame_bytes_ = facts.geometry.frame_bytes();
  writer.zeros_.resize(writer.frame_bytes_);
  writer.unwritten_ = facts_text(facts);
  if (auto written = writer.flush(); !written) {
    unlink(paths.frames.c_str());
    unlink(paths.pixels.c_str());
    return written.error();
  }
  return writer;
}

Result<void> SegmentWriter::append(const RecordedFrame& frame, std::span<const std::uint8_t> pixels) {
  const std::span<const std::uint8_t> stored =
      frame.usable() ? pixels : std::span<const std::uint8_t>(zeros_);
  const int failure = append_whole(pixels_file_.get(), pixel_bytes_,
                                   {reinterpret_cast<const char*>(stored.data()), stored.size()});
  if (failure != 0) return failed(paths_.pixels, failure);
  unwritten_ += bytes_of(record_of(frame, frames_, crc32c(stored)));
  if (frames_ == 0) first_time_ns_ = frame.stamp.capture_time_ns;
  last_time_ns_ = std::max(last_time_ns_, frame.stamp.capture_time_ns);
  ++frames_;
  pixel_bytes_ += stored.size();
  return {};
}

Result<void> SegmentWriter::add_picture(std::string_view line) {
  if (!pictures_file_.is_open()) pictures_file_ = OwnedFile(paths_.pictures, O_WRONLY | O_CREAT | O_EXCL);
  if (!pictures_file_.is_open()) return failed(paths_.pictures, errno);
  const std::string ended = std::string(line) + '\n';
  const int failure = append_whole(pictures_file_.get(), picture_bytes_, ended);
  if (failure != 0) return failed(paths_.pictures, failure);
  picture_bytes_ += ended.size();
  return {};
}

Result<void> SegmentWriter::flush() {
  if (unwritten_.empty()) return {};
  const int failure = append_whole(frames_file_.get(), record_bytes_, unwritten_);
  if (failure != 0) return failed(paths_.frames, failure);
  record_bytes_ += unwritten_.size();
  flushed_frames_ = frames_;
  unwritten_.clear();
  return {};
}

Error SegmentWriter::failed(const std::filesystem::path& path, int reason) const {
  return {ErrorCode::kUnavailable,
          fmt::format("{} could not be written ({}), expected room and permission", shown(path),
                      std::strerror(reason))};  // NOLINT(concurrency-mt-unsafe)
}

Result<Segment> read_segment(const SegmentPaths& paths) {
  const OwnedFile frames(paths.frames, O_RDONLY);
  const OwnedFile pixels(paths.pixels, O_RDONLY);
  if (!frames.is_open() || !pixels.is_open()) {
    const std::filesystem::path& lacks = !frames.is_open() ? paths.frames : paths.pixels;
    std::error_code failure;
    const bool there = std::filesystem::exists(lacks, failure) || failure;
    return Error{there ? ErrorCode::kUnavailable : ErrorCode::kNotFound,
                 fmt::format("{}: a part of the recording {}, expected one that this user may read",
                             shown(lacks), there ? "cannot be read" : "is missing")};
  }
  auto facts = read_facts(frames.get(), paths.frames);
  if (!facts) return facts.error();
  const std::uint64_t present = size_of(pixels.get()) / facts->geometry.frame_bytes();
  Segment segment{.paths = paths, .facts = *std::move(facts), .frames = {}, .pixel_checksums = {}};
  FrameRecord record{};
  for (; segment.records < kMostFrames; ++segment.records) {
    if (!read_whole(frames.get(), &record, sizeof record) || !plausible(record, segment.records)) break;
    if (segment.records >= present) continue;
    segment.frames.push_back(frame_of(record));
    segment.pixel_checksums.push_back(record.pixels_crc);
  }
  return segment;
}

}  // namespace fanlight

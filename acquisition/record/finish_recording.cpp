// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/finish_recording.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <span>
#include <system_error>
#include <utility>

#include "acquisition/record/pixel_copy.hpp"
#include "acquisition/record/recording_names.hpp"
#include "acquisition/sequence/plus_fields.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/base/crc32c.hpp"
#include "proto/base/file_replacement.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kPieceBytes = std::size_t{1} << 20;

/// Frames of a segment that go into the file, from `first` on.
struct Piece {
  Segment segment;
  std::uint64_t first = 0;
  std::uint64_t frames = 0;
  std::vector<std::uint64_t> damaged;  ///< frames of the segment whose pixels differ from their checksum

  std::uint64_t frame_bytes() const { return segment.facts.geometry.frame_bytes(); }
};

Error unwritable(const std::filesystem::path& path, int reason) {
  return {ErrorCode::kUnavailable, fmt::format("{} could not be written ({}), expected room and permission",
                                               shown(path), std::generic_category().message(reason))};
}

Error taken(const std::filesystem::path& path) {
  return {ErrorCode::kInvalidArgument, fmt::format("{} exists already, expected a new name", shown(path))};
}

/// Gives a new file its name, unless there is something of that name. `mark`: a further name that it gets
/// before, where the file system has such names; empty: none.
Result<void> name_file(ReplacementFile& next, const std::filesystem::path& path,
                       const std::filesystem::path& mark = {}) {
  if (const int failure = next.sync()) return unwritable(path, failure);
  if (!mark.empty()) next.add_name(mark);
  const int failure = next.rename_if_free(path);
  if (failure != 0 && !mark.empty()) unlink(mark.c_str());
  if (failure == EEXIST) return taken(path);
  if (failure != 0) return unwritable(path, failure);
  sync_folder_of(path);
  return {};
}

Error stopped(const std::filesystem::path& path) {
  return {ErrorCode::kStopped,
          fmt::format("{} was not finished, expected fanlight recover to do so", shown(path))};
}

/// Marks the frames whose pixels differ from their checksum: after a power cut, or on a bad disk. Those
/// behind them are kept.
Result<void> find_damage(Piece& piece, const std::filesystem::path& path, const std::stop_token& stop) {
  const PixelReader pixels(piece.segment.paths.pixels);
  std::vector<std::uint8_t> frame(piece.frame_bytes());
  for (std::uint64_t i = 0; i < piece.frames; ++i) {
    if (stop.stop_requested()) return stopped(path);
    if (auto read = pixels.read(i * piece.frame_bytes(), frame); !read) return read;
    if (crc32c(frame) == piece.segment.pixel_checksums[i]) continue;
    piece.damaged.push_back(i);
    piece.segment.frames[i].fault = FrameFault::kDamaged;
  }
  return {};
}

/// Frames of a segment that were begun: records without pixels, or pixels without a record.
std::uint64_t lost_frames(const Segment& segment) {
  std::error_code failure;
  const std::uint64_t bytes = std::filesystem::file_size(segment.paths.pixels, failure);
  const std::uint64_t with_pixels = failure ? 0 : bytes / segment.facts.geometry.frame_bytes();
  return std::max(with_pixels, segment.records) - segment.frames.size();
}

Result<std::vector<Piece>> read_pieces(const std::vector<SegmentPaths>& paths,
                                       const std::filesystem::path& path, const FinishOptions& options,
                                       std::uint64_t& lost, const std::stop_token& stop) {
  std::vector<Piece> pieces;
  for (const SegmentPaths& each : paths) {
    auto segment = read_segment(each);
    // One that is lost must not cost the others.
    if (!segment && segment.error().code == ErrorCode::kNotFound) continue;
    if (!segment) return segment.error();
    lost += lost_frames(*segment);
    if (segment->frames.empty()) continue;
    const std::uint64_t frames = segment->frames.size();
    pieces.push_back({.segment = *std::move(segment), .first = 0, .frames = frames, .damaged = {}});
    if (!options.check_pixels) continue;
    if (auto found = find_damage(pieces.back(), path, stop); !found) return found.error();
  }
  return pieces;
}

std::uint64_t damaged_frames(const std::vector<Piece>& pieces) {
  std::uint64_t damaged = 0;
  for (const Piece& piece : pieces) damaged += piece.damaged.size();
  return damaged;
}

/// Leaves the last seconds only.
void keep_last(std::vector<Piece>& pieces, double last_s) {
  if (last_s <= 0 || pieces.empty()) return;
  const auto time_ns = [](const Piece& piece, std::uint64_t frame) {
    return piece.segment.frames[piece.first + frame].stamp.capture_time_ns;
  };
  const std::int64_t from_ns =
      time_ns(pieces.back(), pieces.back().frames - 1) - static_cast<std::int64_t>(last_s * 1e9);
  for (Piece& piece : pieces) {
    std::uint64_t skipped = 0;
    while (skipped < piece.frames && time_ns(piece, skipped) < from_ns) ++skipped;
    piece.first += skipped;
    piece.frames -= skipped;
    if (piece.frames > 0) break;
  }
  std::erase_if(pieces, [](const Piece& piece) { return piece.frames == 0; });
}

struct FrameText {
  std::string text;
  std::uint64_t frames = 0;
  double duration_s = 0;
  std::uint64_t first_sequence = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t last_sequence = 0;
};

FrameText frame_text(const std::vector<Piece>& pieces) {
  FrameText all;
  const Piece& front = pieces.front();
  const std::int64_t first_ns = front.segment.frames[front.first].stamp.capture_time_ns;
  for (const Piece& piece : pieces) {
    for (std::uint64_t i = 0; i < piece.frames; ++i) {
      const RecordedFrame& frame = piece.segment.frames[piece.first + i];
      all.duration_s =
          add_plus_frame(all.text, all.frames++, front.segment.facts, frame, first_ns, all.duration_s);
      all.first_sequence = std::min(all.first_sequence, frame.stamp.sequence);
      all.last_sequence = std::max(all.last_sequence, frame.stamp.sequence);
    }
  }
  return all;
}

/// Zeroes what `bytes`, read from `at` on, has of damaged frames.
void blank_damage(const Piece& piece, std::uint64_t at, std::span<std::uint8_t> bytes) {
  const std::uint64_t size = piece.frame_bytes();
  for (const std::uint64_t frame : piece.damaged) {
    const std::uint64_t from = std::max(frame * size, at);
    const std::uint64_t to = std::min((frame + 1) * size, at + bytes.size());
    if (from < to) std::ranges::fill(bytes.subspan(from - at, to - from), std::uint8_t{0});
  }
}

/// Pixels of all pieces to the sink.
Result<void> copy_pixels(const std::vector<Piece>& pieces, PixelSink& sink, const std::filesystem::path& path,
                         FinishProgress& progress, const std::stop_token& stop) {
  std::vector<std::uint8_t> bytes(kPieceBytes);
  for (const Piece& piece : pieces) {
    const PixelReader pixels(piece.segment.paths.pixels);
    const std::uint64_t end = (piece.first + piece.frames) * piece.frame_bytes();
    for (std::uint64_t at = piece.first * piece.frame_bytes(); at < end; at += bytes.size()) {
      if (stop.stop_requested()) return stopped(path);
      const std::span some = std::span(bytes).first(std::min<std::uint64_t>(bytes.size(), end - at));
      if (auto read = pixels.read(at, some); !read) return read;
      blank_damage(piece, at, some);
      if (const int failure = sink.write(some)) return unwritable(path, failure);
      progress.bytes_done += some.size();
    }
  }
  if (const int failure = sink.finish()) return unwritable(path, failure);
  return stop.stop_requested() ? Result<void>(stopped(path)) : Result<void>();
}

/// Gives the file with the pixels of the only piece a second name, and sees to it that it is on the disk.
/// False where they must be copied.
Result<bool> link_pixels(const std::vector<Piece>& pieces, PixelForm form, const std::filesystem::path& to) {
  const bool whole = pieces.size() == 1 && pieces.front().first == 0 && form == PixelForm::kRaw &&
                     pieces.front().damaged.empty();
  if (!whole) return false;
  const Piece& piece = pieces.front();
  const std::filesystem::path& from = piece.segment.paths.pixels;
  // A kill between the names may have left it.
  if (same_file(from, to)) return true;
  // Bytes of a frame that is not whole.
  std::error_code failure;
  std::filesystem::resize_file(from, piece.frames * piece.frame_bytes(), failure);
  if (failure) return false;
  const int file = open(from.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = file >= 0 && fdatasync(file) == 0;
  if (file >= 0) close(file);
  if (!synced) return false;
  if (link(from.c_str(), to.c_str()) == 0) {
    sync_folder_of(to);
    return true;
  }
  if (errno == EEXIST) return taken(to);
  return false;
}

Result<void> write_text(const std::filesystem::path& path, std::string_view text,
                        const std::filesystem::path& mark = {}) {
  ReplacementFile next;
  if (const int failure = next.create_unnamed(path, 0600)) return unwritable(path, failure);
  if (const int failure = write_all(next.descriptor(), text)) return unwritable(path, failure);
  return name_file(next, path, mark);
}

std::filesystem::path mark_of(const std::vector<Piece>& pieces) {
  return finished_mark(pieces.front().segment.paths);
}

/// One file: the header, and the pixels behind it.
Result<std::uint64_t> write_joined(const std::vector<Piece>& pieces, const FrameText& frames,
                                   const std::filesystem::path& path, PixelForm form,
                                   FinishProgress& progress, const std::stop_token& stop) {
  ReplacementFile next;
  if (const int failure = next.create_unnamed(path, 0600)) return unwritable(path, failure);
  const RecordingFacts& facts = pieces.front().segment.facts;
  PlusHeader header{.frames = frames.frames, .compressed_bytes = std::nullopt};
  if (form == PixelForm::kZlib) header.compressed_bytes = 0;
  const std::string rest = frames.text + plus_data_line("LOCAL");
  std::string first = plus_header(facts, header);
  if (const int failure = write_all(next.descriptor(), first + rest)) return unwritable(path, failure);
  PixelSink sink(next.descriptor(), form);
  if (auto copied = copy_pixels(pieces, sink, path, progress, stop); !copied) return copied.error();
  if (form == PixelForm::kZlib) {
    header.compressed_bytes = sink.written();
    first = plus_header(facts, header);  // as long as before
    if (lseek(next.descriptor(), 0, SEEK_SET) != 0) return unwritable(path, errno);
    if (const int failure = write_all(next.descriptor(), first)) return unwritable(path, failure);
  }
  if (auto named = name_file(next, path, mark_of(pieces)); !named) return named.error();
  return first.size() + rest.size() + sink.written();
}

/// A header, and a separate file with the pixels.
Result<std::uint64_t> write_pair(const std::vector<Piece>& pieces, const FrameText& frames,
                                 const std::filesystem::path& path, PixelForm form, FinishProgress& progress,
                                 const std::stop_token& stop) {
  const std::filesystem::path pixels_path = pixels_path_of(path, form);
  std::error_code ignored;
  // Before anything of it is touched.
  if (std::filesystem::exists(path, ignored)) return taken(path);
  const bool was_there = std::filesystem::exists(pixels_path, ignored);
  std::uint64_t pixel_bytes = frames.frames * pieces.front().frame_bytes();
  const auto linked = link_pixels(pieces, form, pixels_path);
  if (!linked) return linked.error();
  if (!*linked) {
    ReplacementFile next;
    if (const int failure = next.create_unnamed(pixels_path, 0600)) return unwritable(pixels_path, failure);
    PixelSink sink(next.descriptor(), form);
    if (auto copied = copy_pixels(pieces, sink, pixels_path, progress, stop); !copied) return copied.error();
    if (auto named = name_file(next, pixels_path); !named) return named.error();
    pixel_bytes = sink.written();
  }
  PlusHeader header{.frames = frames.frames, .compressed_bytes = std::nullopt};
  if (form == PixelForm::kZlib) header.compressed_bytes = pixel_bytes;
  const std::string text = plus_header(pieces.front().segment.facts, header) + frames.text +
                           plus_data_line(pixels_path.filename().string());
  if (auto written = write_text(path, text, mark_of(pieces)); !written) {
    if (!was_there) unlink(pixels_path.c_str());
    return written.error();
  }
  return text.size() + pixel_bytes;
}

/// The lines of all segments; a last one that was cut off is left out.
Result<void> write_pictures(const std::vector<SegmentPaths>& segments, const std::filesystem::path& path) {
  std::string all;
  for (const SegmentPaths& each : segments) {
    std::ifstream file(each.pictures, std::ios::binary);
    std::string lines((std::istreambuf_iterator<char>(file)), {});
    lines.resize(lines.rfind('\n') + 1);  // 0 without one
    all += lines;
  }
  return all.empty() ? Result<void>() : write_text(picture_notes_path_of(path), all);
}

/// Whether a copy of the pixels leaves the disk enough for what is recorded meanwhile.
bool has_room_for_copy(const std::vector<SegmentPaths>& segments, const std::filesystem::path& path) {
  constexpr std::uint64_t kReserveBytes = 128'000'000;
  std::uint64_t bytes = kReserveBytes;
  std::error_code failure;
  for (const SegmentPaths& each : segments) {
    const auto size = std::filesystem::file_size(each.pixels, failure);
    if (!failure) bytes += size;
  }
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  const auto disk = std::filesystem::space(folder, failure);
  return failure || disk.available >= bytes;
}

/// Removes segments without a frame. Where there are pixels without a record of them, they stay for a person.
void remove_empty(const std::vector<SegmentPaths>& segments) {
  std::error_code failure;
  const bool empty = std::ranges::all_of(segments, [&failure](const SegmentPaths& each) {
    const auto bytes = std::filesystem::file_size(each.pixels, failure);
    return failure || bytes == 0;
  });
  if (empty) remove_segments(segments);
}

bool one_file(const std::filesystem::path& path) {
  return path.extension() == ".mha";
}

}  // namespace

Result<FinishedRecording> finish_recording(const std::vector<SegmentPaths>& segments,
                                           const std::filesystem::path& path, const FinishOptions& options,
                                           FinishProgress& progress, const std::stop_token& stop) {
  if (auto named = check_recording_name(path); !named) return named.error();
  FinishedRecording finished{.path = path};
  auto pieces = read_pieces(segments, path, options, finished.frames_lost, stop);
  if (!pieces) return pieces.error();
  keep_last(*pieces, options.last_s);
  if (pieces->empty()) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("{}: the recording has no whole frame, expected one at least", shown(path))};
  }
  finished.frames_damaged = damaged_frames(*pieces);
  const FrameText frames = frame_text(*pieces);
  finished.frames = frames.frames;
  finished.duration_s = frames.duration_s;
  finished.first_sequence = frames.first_sequence;
  finished.last_sequence = frames.last_sequence;
  progress.bytes_in_all = frames.frames * pieces->front().frame_bytes();
  const auto bytes = one_file(path) ? write_joined(*pieces, frames, path, options.form, progress, stop)
                                    : write_pair(*pieces, frames, path, options.form, progress, stop);
  if (!bytes) return bytes.error();
  finished.bytes = *bytes;
  // Worth less than the frames: where there is no room for the lines, the recording is finished without them.
  (void)write_pictures(segments, path);
  remove_segments(segments);
  unlink(finished_mark(segments.front()).c_str());
  return finished;
}

Result<FinishedRecording> finish_in_any_form(const std::vector<SegmentPaths>& segments,
                                             const std::filesystem::path& path, const FinishOptions& options,
                                             FinishProgress& progress, const std::stop_token& stop) {
  const bool copies = path.extension() == ".mha";
  if (!copies || segments.size() > 1 || has_room_for_copy(segments, path)) {
    auto finished = finish_recording(segments, path, options, progress, stop);
    if (!finished && finished.error().code == ErrorCode::kNotFound) remove_empty(segments);
    if (!copies || finished || finished.error().code != ErrorCode::kUnavailable) return finished;
  }
  std::filesystem::path pair = path;
  pair.replace_extension(".mhd");
  FinishOptions raw = options;
  raw.form = PixelForm::kRaw;
  return finish_recording(segments, pair, raw, progress, stop);
}

}  // namespace fanlight

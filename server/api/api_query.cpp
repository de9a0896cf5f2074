// SPDX-License-Identifier: Apache-2.0
#include "server/api/api_query.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <boost/url/parse.hpp>
#include <boost/url/url_view.hpp>
#include <charconv>
#include <vector>

#include "proto/base/printable.hpp"
#include "proto/model/picture_size_text.hpp"

namespace fanlight {

namespace {

constexpr int kMostQuality = 100;
constexpr double kMostRateHz = 1000;

Error bad_query(std::string sentence) {
  return {ErrorCode::kInvalidArgument, std::move(sentence)};
}

/// The whole text as a number; absent: it is none.
std::optional<double> number_of(std::string_view text) {
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = failure == std::errc() && end == text.data() + text.size();
  return whole ? std::optional(value) : std::nullopt;
}

Result<double> number_in(const ApiQuery& query, std::string_view name, double least, double most,
                         double otherwise, std::string_view expected) {
  const auto found = query.find(name);
  if (found == query.end()) return otherwise;
  const auto value = number_of(found->second);
  if (!value || !(*value >= least && *value <= most))
    return bad_query(
        fmt::format("{} is \"{}\", expected {}", name, printable(found->second.substr(0, 40)), expected));
  return *value;
}

}  // namespace

Result<ApiQuery> parse_query(std::string_view target, std::span<const QueryParameter> known) {
  ApiQuery query;
  const auto url = boost::urls::parse_origin_form(target);
  if (!url) return bad_query("the target is no path with a query, expected one");
  if (!url->has_query()) return query;
  for (const auto parameter : url->params()) {
    const std::string name(parameter.key);
    if (std::ranges::find(known, name, &QueryParameter::name) == known.end()) {
      std::vector<std::string_view> names;
      for (const QueryParameter& each : known) names.push_back(each.name);
      return bad_query(fmt::format("the query has the parameter \"{}\", expected {}",
                                   printable(name.substr(0, 40)),
                                   names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
    }
    if (!query.emplace(name, std::string(parameter.value)).second)
      return bad_query(fmt::format("the query has {} twice, expected it once", name));
  }
  return query;
}

Result<std::uint64_t> wanted_revision(const ApiQuery& query) {
  const auto found = query.find("revision");
  if (found == query.end()) return std::uint64_t{0};
  std::uint64_t revision = 0;
  const std::string& text = found->second;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), revision);
  if (failure != std::errc() || end != text.data() + text.size())
    return bad_query(
        fmt::format("revision is \"{}\", expected that of a scene", printable(text.substr(0, 40))));
  return revision;
}

Result<StreamSettings> jpeg_settings(const ApiQuery& query, int default_quality) {
  StreamSettings settings{.codec = StreamSettings::Codec::kJpeg, .quality = default_quality};
  if (const auto size = query.find("size"); size != query.end()) {
    const auto parsed = parse_picture_size(size->second);
    if (!parsed) return parsed.error();
    settings.most_width = parsed->width;
    settings.most_height = parsed->height;
  }
  const auto quality =
      number_in(query, "quality", 1, kMostQuality, default_quality, "a whole number of 1 to 100");
  if (!quality) return quality.error();
  settings.quality = static_cast<int>(*quality);
  if (settings.quality != *quality) return bad_query("quality is no whole number, expected 1 to 100");
  const auto rate = number_in(query, "rate", 1e-3, kMostRateHz, 0, "pictures a second, 0.001 to 1000");
  if (!rate) return rate.error();
  settings.rate_hz = *rate;
  return settings;
}

}  // namespace fanlight

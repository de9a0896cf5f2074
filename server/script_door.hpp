#pragma once

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>

#include "server/stream_context.hpp"

namespace fanlight {

/// What scripts may ask for over plain HTTP, with the rights that a display would have:
///
///   GET   /api/scene         the scene in force, as JSON
///   PATCH /api/scene         changes some of its fields: {"light": {"up_mm": 20}}
///   GET   /api/picture.png   the newest picture
///
/// Server thread only.
class ScriptDoor {
 public:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;
  using Response = boost::beast::http::response<boost::beast::http::string_body>;

  explicit ScriptDoor(const StreamContext& context) : context_(context) {}

  /// `path`: the request's, without what follows a '?', from "/api/" on.
  Response respond(const Request& request, std::string_view path, const Visitor& visitor);

 private:
  Response scene() const;
  Response change_scene(const Request& request, const Visitor& visitor);
  Response picture() const;

  const StreamContext& context_;
};

}  // namespace fanlight

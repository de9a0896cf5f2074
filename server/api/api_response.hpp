// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <nlohmann/json.hpp>

namespace google::protobuf {
class Message;
}

namespace fanlight {

using ApiRequest = boost::beast::http::request<boost::beast::http::string_body>;
using ApiResponse = boost::beast::http::response<boost::beast::http::string_body>;

ApiResponse json_response(boost::beast::http::status status, const nlohmann::ordered_json& body);

/// The fields of a message by name, in the order of their numbers, also those that have their default;
/// choices by name in lower case. Precondition: no field is repeated, or a message.
nlohmann::ordered_json message_json(const google::protobuf::Message& message);

/// A browser sends JSON to another site only after a preflight request, which this server does not grant.
bool is_json(const ApiRequest& request);

}  // namespace fanlight

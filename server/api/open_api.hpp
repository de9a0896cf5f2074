// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

namespace fanlight {

/// The description of the REST API as OpenAPI 3.1, from api_operations() and api_schemas(). Some
/// milliseconds.
nlohmann::ordered_json open_api();

/// The same as a short list, for GET /api.
nlohmann::ordered_json operation_list();

}  // namespace fanlight

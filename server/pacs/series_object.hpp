// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/dicom/dataset_fields.hpp"
#include "server/pacs/dicom_series.hpp"

namespace fanlight {

/// Adds what all pictures of a series have: identity, times (now, in UTC), series, equipment, and that they
/// are derived, have text in their pixels and are not for diagnosis. Advances the series.
void begin_object(DicomFields& fields, const char* sop_class, DicomSeries& series);

/// The file's bytes. `failed`: whether a field could not be added. `pixel_bytes`: how large the pixels are.
/// kUnavailable: it cannot be made.
Result<std::vector<std::uint8_t>> object_bytes(DcmFileFormat& file, bool failed, E_TransferSyntax syntax,
                                               std::size_t pixel_bytes);

}  // namespace fanlight

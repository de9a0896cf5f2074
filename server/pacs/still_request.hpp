// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "proto/base/result.hpp"
#include "proto/dicom/identity.hpp"
#include "server/codec/png_reader.hpp"

namespace fanlight {

/// What a display sends to the archive.
struct StillRequest {
  DicomIdentity patient;
  RgbPicture picture;
  double lossy_ratio = 0;  // as of PictureToSend
  const char* lossy_method = "";
};

/// Reads {"png": BASE64, "patient": {"patient_id": ...}}, and, where the display had the picture as JPEG or
/// H.264, "lossy": {"method": "jpeg" or "h264", "ratio": NUMBER}. Errors: kInvalidArgument, another form, a
/// field of the patient that DICOM cannot hold, or a patient with neither ID nor name; kBadInput, of the
/// picture. The sentence never has a value of the patient.
Result<StillRequest> parse_still_request(std::string_view body);

/// Reads {"volume": ANY, "patient": {"patient_id": ...}}. Errors: as above.
Result<DicomIdentity> parse_volume_request(std::string_view body);

}  // namespace fanlight

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <variant>

#include "proto/base/result.hpp"
#include "proto/dicom/identity.hpp"
#include "server/codec/png_reader.hpp"
#include "server/pacs/clip_object.hpp"

namespace fanlight {

/// What a display sends to the archive.
struct StillRequest {
  DicomIdentity patient;
  RgbPicture picture;
  double lossy_ratio = 0;  // as of PictureToSend
  const char* lossy_method = "";
};

struct ClipRequest {
  DicomIdentity patient;
  Jpegs jpegs;  // not looked at
  double pictures_per_second = 0;
};

using PictureRequest = std::variant<StillRequest, ClipRequest>;

/// Reads {"png": BASE64, "patient": {"patient_id": ...}}, and, where the display had the picture as JPEG or
/// H.264, "lossy": {"method": "jpeg" or "h264", "ratio": NUMBER}; or a clip, {"jpegs":
/// [BASE64, ...], "pictures_per_second": NUMBER, "patient": ...}. Errors: kInvalidArgument, another form, a
/// field of the patient that DICOM cannot hold, or a patient with neither ID nor name; kBadInput, of the
/// picture. The sentence never has a value of the patient.
Result<PictureRequest> parse_picture_request(std::string_view body);

/// Reads {"volume": ANY, "patient": {"patient_id": ...}}. Errors: as above.
Result<DicomIdentity> parse_volume_request(std::string_view body);

}  // namespace fanlight

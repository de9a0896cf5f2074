// SPDX-License-Identifier: Apache-2.0
#pragma once

// DCMTK's first header must come first.
#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "proto/dicom/identity.hpp"

namespace fanlight {

/// Fills an item of DCMTK. The first failure stays in `failed`.
class DicomFields {
 public:
  /// Both must outlive this.
  DicomFields(DcmItem& item, bool& failed) : item_(item), failed_(failed) {}

  void text(const DcmTagKey& key, const std::string& value) {
    put(item_.putAndInsertString(key, value.c_str()));
  }
  /// A field that must be there and may be empty (type 2).
  void empty(const DcmTagKey& key) { put(item_.insertEmptyElement(key)); }
  /// A field that is left out where nothing is known (type 3).
  void optional_text(const DcmTagKey& key, const std::string& value) {
    if (!value.empty()) text(key, value);
  }
  void whole(const DcmTagKey& key, std::uint32_t value) {
    put(item_.putAndInsertUint16(key, static_cast<Uint16>(value)));
  }
  void index(const DcmTagKey& key, Uint32 value) { put(item_.putAndInsertUint32Array(key, &value, 1)); }
  void tag(const DcmTagKey& key, const DcmTagKey& value) { put(item_.putAndInsertTagKey(key, value)); }
  template <std::size_t kCount>
  void numbers(const DcmTagKey& key, const std::array<double, kCount>& values) {
    put(item_.putAndInsertFloat64Array(key, values.data(), kCount));
  }
  void bytes(const DcmTagKey& key, std::span<const std::uint8_t> values) {
    put(item_.putAndInsertUint8Array(key, values.data(), values.size()));
  }
  /// The item of a sequence, a new one.
  DicomFields item(const DcmTagKey& key) {
    constexpr signed long kNew = -2;
    DcmItem* made = nullptr;
    put(item_.findOrCreateSequenceItem(key, made, kNew));
    return {made != nullptr ? *made : item_, failed_};
  }
  void code(const DcmTagKey& key, const char* value, const char* scheme, const char* meaning) {
    DicomFields of = item(key);
    of.text(DCM_CodeValue, value);
    of.text(DCM_CodingSchemeDesignator, scheme);
    of.text(DCM_CodeMeaning, meaning);
  }

 private:
  void put(const OFCondition& done) { failed_ = failed_ || done.bad(); }

  DcmItem& item_;
  bool& failed_;
};

/// The values of a text field, without the spaces at their end; empty where there is none. In the character
/// set of the item.
std::string dicom_text(DcmItem& item, const DcmTagKey& key);

/// A new unique identifier below one of DCMTK's SITE_..._UID_ROOT.
std::string new_dicom_uid(const char* root);

/// Patient and Study modules (PS3.3 C.7.1.1 and C.7.2.1), the order (Request Attributes Sequence, C.7.3.1),
/// and the character set, UTF-8. A study without a UID gets a new one.
void add_identity(DicomFields& fields, const DicomIdentity& identity);

/// Silences DCMTK's log, which is global and would name patients. Any thread; the first call counts.
void silence_dicom_log();

}  // namespace fanlight

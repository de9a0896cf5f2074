// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "acquisition/replay/sequence_header.hpp"

namespace fanlight {

/// Reads the text of a NRRD sequence (.nrrd, .seq.nrrd, .nhdr; teem.sourceforge.net/nrrd/format.html), up to
/// its empty line, and checks it: the frames on the last axis; 8 and 16 bit; raw or gzip. The fields of
/// frames are key/value pairs, named as in a MetaImage sequence. kUnsupported for other forms, else
/// kBadInput.
Result<SequenceHeader> read_nrrd_header(const NamedFile& from);

}  // namespace fanlight

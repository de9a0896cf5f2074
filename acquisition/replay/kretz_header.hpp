// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "acquisition/replay/sequence_header.hpp"

namespace fanlight {

/// Reads a Kretz volume (.vol of GE Voluson): one B-mode volume, not compressed, with the geometry of a swept
/// curved array. The layout is not public; it is that of two open readers (plooney/kretz,
/// itkKretzImageIO.cxx; SlicerHeart, vtkSlicerKretzFileReaderLogic.cxx): after "KRETZFILE 1.0   " items of
/// group u16, element u16, length u32 and data, little endian. Patient, hospital and study fields are skipped
/// unread.
///
/// With the radial step s, offset1 and offset2 of the file, sample i of a line lies r = (offset1 + i) s from
/// the lines' apex, and the sweep axis d = -offset2 s from it: probe_radius_mm = offset1 s, motor_radius_mm =
/// probe_radius_mm - d. The lines' table of angles must be even; the sweep's gives the motor angles. Frames
/// have no times: they are 10 ms apart.
///
/// kUnsupported names what the file has instead: a compressed volume, several volumes, a Cartesian one; else
/// kBadInput.
Result<SequenceHeader> read_kretz_header(const NamedFile& from);

}  // namespace fanlight

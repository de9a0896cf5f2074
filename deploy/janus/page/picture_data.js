// SPDX-License-Identifier: Apache-2.0
// Reads what Fanlight says of each picture from the SEI messages of its H.264 (proto/RTP.md).

const UUID = [0x5d, 0x41, 0x2e, 0x9c, 0x7b, 0x60, 0x4f, 0x3a, 0x9e, 0x18, 0xc2, 0x6f, 0x0b, 0x84, 0xd7, 0x35];
const SEI_UNIT = 6;
const USER_DATA_UNREGISTERED = 5;

/** Where the next start code begins, from `from` on; the length of the stream if there is none. */
function findStartCode(stream, from) {
  for (let at = from; at + 3 <= stream.length; ++at) {
    if (stream[at] === 0 && stream[at + 1] === 0 && stream[at + 2] === 1) return at;
  }
  return stream.length;
}

/** The payload of a unit without the bytes that keep it from looking like a start code. */
function withoutEscapes(unit) {
  const plain = [];
  let zeros = 0;
  for (const byte of unit) {
    if (zeros === 2 && byte === 3) {
      zeros = 0;
      continue;
    }
    plain.push(byte);
    zeros = byte === 0 ? zeros + 1 : 0;
  }
  return Uint8Array.from(plain);
}

/** The JSON text of one SEI unit; null: it has other data. */
function dataOfUnit(unit) {
  const plain = withoutEscapes(unit.subarray(1));
  let at = 0;
  const number = () => {
    let value = 0;
    for (;;) {
      const byte = plain[at++] ?? 0;
      value += byte;
      if (byte !== 255) return value;
    }
  };
  const kind = number();
  const bytes = number();
  if (kind !== USER_DATA_UNREGISTERED || bytes < UUID.length || at + bytes > plain.length) return null;
  if (!UUID.every((byte, index) => plain[at + index] === byte)) return null;
  return new TextDecoder().decode(plain.subarray(at + UUID.length, at + bytes));
}

/** What is said of the encoded picture (Uint8Array, H.264 with start codes); null: nothing. */
export function pictureData(stream) {
  for (let code = findStartCode(stream, 0); code < stream.length; ) {
    const begin = code + 3;
    code = findStartCode(stream, begin);
    if ((stream[begin] & 31) !== SEI_UNIT) continue;
    const text = dataOfUnit(stream.subarray(begin, code));
    if (text === null) continue;
    try {
      return JSON.parse(text);
    } catch {
      return null;
    }
  }
  return null;
}

// SPDX-License-Identifier: BSD-3-Clause
// Observations of landmarks, unpacked from the data of the viewer (PackObservers in observers.h).

/** {ids, starts, rows}: landmark i has id ids[i], and is observed by the keyframes in rows[starts[i]..starts[i + 1]]. */
export function unpackObservers(bytes) {
  let at = 0;
  const next = () => {
    let number = 0;
    for (let factor = 1; ; factor *= 128) {
      const byte = bytes[at++];
      number += (byte & 127) * factor;
      if (byte < 128) return number;
    }
  };
  const ids = [];
  const starts = [0];
  const rows = [];
  let first = 0;
  while (at < bytes.length) {
    ids.push((ids.at(-1) ?? -1) + next());
    const n = next();
    if (n) {
      const difference = next();
      first += difference % 2 ? -(difference + 1) / 2 : difference / 2;
      let row = first;
      rows.push(row);
      for (let i = 1; i < n; ++i) rows.push((row += next()));
    }
    starts.push(rows.length);
  }
  return { ids, starts, rows };
}

/** Returns a packed standard deviation (PackSigma) in metres; NaN if it is unknown. */
export function unpackSigma(packed) {
  return packed ? 1e-4 * 1.05 ** (packed - 1) : NaN;
}

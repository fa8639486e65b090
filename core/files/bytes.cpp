// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/bytes.h"

#include <sodium.h>

namespace plslam {

std::string Base64(std::string_view bytes) {
  // With the terminating zero that sodium writes.
  std::string text(sodium_base64_ENCODED_LEN(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text.data(), text.size(), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
                    sodium_base64_VARIANT_ORIGINAL);
  text.pop_back();
  return text;
}

}  // namespace plslam

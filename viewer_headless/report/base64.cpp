#include "viewer_headless/report/base64.h"

#include <sodium.h>

#include <bit>
#include <cstring>
#include <type_traits>

namespace plslam {

std::string Base64(std::string_view bytes) {
  // With the terminating zero that sodium writes.
  std::string text(sodium_base64_ENCODED_LEN(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text.data(), text.size(), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
                    sodium_base64_VARIANT_ORIGINAL);
  text.pop_back();
  return text;
}

std::string LittleEndianBytes(const Column& column) {
  static_assert(std::endian::native == std::endian::little, "the page reads little endian");
  return std::visit(
      [](const auto& values) {
        std::string bytes(values.size() * sizeof(values[0]), '\0');
        if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
        return bytes;
      },
      column.values);
}

std::string TypeName(const Column& column) {
  if (std::holds_alternative<std::vector<float>>(column.values)) return "f32";
  if (std::holds_alternative<std::vector<int32_t>>(column.values)) return "i32";
  return std::holds_alternative<std::vector<uint16_t>>(column.values) ? "u16" : "u8";
}

}  // namespace plslam

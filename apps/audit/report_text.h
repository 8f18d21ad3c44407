#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tintree::audit {

/// The text with what HTML would take for markup replaced.
std::string escape_html(std::string_view text);

/// "12 345 678", thin spaces between thousands.
std::string grouped(std::uint64_t number);

/// "1.23 MiB".
std::string bytes_text(std::uint64_t bytes);

/// A length with four digits: "38.49".
std::string metres(double value);

/// "99.98 %", rounded towards 0, so that only what reaches the whole reads 100 %.
std::string share_text(double share);

}  // namespace tintree::audit

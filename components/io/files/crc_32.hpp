// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <boost/crc.hpp>
#include <cstdint>
#include <string_view>

namespace plumb {

// As in zip, PNG and Python's zlib.
inline std::uint32_t crc_32(std::string_view bytes) {
    boost::crc_32_type crc;
    crc.process_bytes(bytes.data(), bytes.size());
    return crc.checksum();
}

}  // namespace plumb

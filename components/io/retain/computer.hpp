// SPDX-License-Identifier: GPL-2.0-or-later
// By what a store knows its computer, and that it is the last one of this computer.
#pragma once

#include "components/io/files/atomic_file.hpp"
#include "components/io/files/crc_32.hpp"
#include "components/io/retain/retained_file.hpp"
#include "hal/regular_file.hpp"

#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <system_error>

namespace plumb {

namespace computer {

namespace fs = std::filesystem;

// The first line of a file; "" if there is none.
inline std::string line_of(const fs::path& file) {
    try {
        const std::string text = hal::RegularFile(file, O_RDONLY).read();
        return text.substr(0, text.find_first_of(std::string("\n\0", 2)));
    } catch (const std::system_error&) {
        return "";
    }
}

// A copied disk has the same machine-id. The board of a Raspberry Pi has a number of its own that every user
// can read; of other computers the disk has one.
inline std::string hardware() {
    const std::string board = line_of("/sys/firmware/devicetree/base/serial-number");
    struct stat root {};
    if (!board.empty() || stat("/", &root) != 0) return board;
    std::error_code error;
    fs::path disk = fs::canonical(
        "/sys/dev/block/" + std::to_string(major(root.st_dev)) + ":" + std::to_string(minor(root.st_dev)),
        error);
    for (int layers = 0; !error && layers < 8; ++layers) {
        for (const char* name : {"wwid", "device/wwid", "device/cid", "device/serial", "serial"})
            if (std::string number = line_of(disk / name); !number.empty()) return number;
        const fs::directory_iterator below(disk / "slaves", error);
        if (!error && below != fs::directory_iterator())
            disk = fs::canonical(below->path(), error);
        else if (fs::exists(disk / "partition", error))
            disk = disk.parent_path();
        else
            return "";
    }
    return "";
}

// "" for a computer without a machine-id. PLUMB_MACHINE_ID names another file that has one.
inline std::string number() {
    const char* const named = std::getenv("PLUMB_MACHINE_ID");
    const std::string id = line_of(named != nullptr ? named : "/etc/machine-id");
    return id.empty() ? "" : retained_file::hexadecimal(crc_32("plumb-retain\n" + id + '\n' + hardware()));
}

// Throws std::system_error without a HOME.
inline fs::path state_folder() {
    const auto named = [](const char* variable) {
        const char* const value = std::getenv(variable);
        return fs::path(value != nullptr ? value : "");
    };
    if (const fs::path state = named("XDG_STATE_HOME"); state.is_absolute()) return state;
    if (const fs::path home = named("HOME"); home.is_absolute()) return home / ".local/state";
    throw std::system_error(ENOENT, std::generic_category(), "HOME");
}

}  // namespace computer

// The computer of a store, and its count of writes, which also stands in a file outside the store. The store
// is written first: after a crash between the two it is ahead by one. All but the constructor may throw
// std::system_error.
class StoreOrigin {
public:
    // Why a store is not taken without a question; Fault::none if it is this computer's last one.
    Fault judge(const std::optional<retained_file::Origin>& stored) {
        if (computer_.empty()) return Fault::nameless;
        if (!stored || stored->computer.empty()) return Fault::unnamed;
        if (stored->computer != computer_) return Fault::computer;
        origin_ = *stored;
        open();
        const std::string text = outside_->read().value_or("");
        const std::int64_t ahead = origin_.count - std::strtoll(text.c_str(), nullptr, 10);
        noted_ = ahead == 0;
        return !text.empty() && (ahead == 0 || ahead == 1) ? Fault::none : Fault::older;
    }

    // From now on a store of this computer, without a past.
    void begin() {
        std::random_device random;
        origin_ = {computer_, retained_file::hexadecimal(random()) + retained_file::hexadecimal(random()), 0};
        outside_.reset();
        noted_ = false;
    }

    const retained_file::Origin& now() const { return origin_; }

    retained_file::Origin next() const {
        retained_file::Origin next = origin_;
        ++next.count;
        return next;
    }

    // The store has been written with next().
    void written() {
        origin_ = next();
        noted_ = false;
    }

    // Before the next write of the store, and after it.
    void note() {
        if (noted_ || origin_.count == 0) return;
        open();
        outside_->write(std::to_string(origin_.count) + '\n');
        noted_ = true;
    }

private:
    void open() {
        if (outside_) return;
        const auto folder = computer::state_folder() / "plumb" / "retain";
        std::filesystem::create_directories(folder);
        outside_.emplace(folder / origin_.store);
    }

    const std::string computer_ = computer::number();
    retained_file::Origin origin_;
    std::optional<AtomicFile> outside_;
    bool noted_ = false;  // outside
};

}  // namespace plumb

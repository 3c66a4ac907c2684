// SPDX-License-Identifier: GPL-2.0-or-later
// The readers of Plumb, each under attack by bytes that anybody may have written.
//
// A reader is one file of this folder, with a corpus of the same name in tests/corpus. It gets bytes, reads
// them as the product does, and demands properties that hold for any bytes. The tests give each reader its
// corpus; `scripts/campaign bytes` lets libFuzzer write the bytes.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace plumb::readers {

class Reader {
public:
    using Read = void (*)(std::string_view bytes);

    // Makes the reader known by its name.
    Reader(const char* name, Read read);
};

// Ends the program with the sentence when it is not so: libFuzzer then keeps the bytes.
void demand(bool so, const std::string& sentence);

// Calls a reader that may refuse. Returns whether it took the bytes; a refusal without a sentence is a
// finding, and so is any exception that is not an `Expected`.
template <class Expected, class Read>
bool takes(const Read& read) {
    try {
        read();
        return true;
    } catch (const Expected& refusal) {
        demand(*refusal.what() != '\0', "it is refused without a sentence");
        return false;
    }
}

// A regular file with these bytes, in memory, for as long as the object lives.
class FileOf {
public:
    explicit FileOf(std::string_view bytes);
    ~FileOf();
    FileOf(const FileOf&) = delete;

    const std::filesystem::path& path() const { return path_; }

private:
    int descriptor_;
    std::filesystem::path path_;
};

}  // namespace plumb::readers

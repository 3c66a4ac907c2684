// SPDX-License-Identifier: GPL-2.0-or-later
// PLUMB_READER=NAME readers FILE_OR_FOLDER...
// In the place of libFuzzer: gives a reader the bytes of each file, and each beginning of them.
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

namespace {

namespace fs = std::filesystem;

constexpr unsigned patience = 20;             // s, for one beginning of a file
constexpr std::size_t longest_in_all = 1024;  // bytes of a file each of whose beginnings is read

std::string under_way;  // the file that is read

void read_bytes(const std::string& text) {
    alarm(patience);
    // A copy of its own size, beyond which the sanitizer sees every step.
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
}

void read_file(const fs::path& file) {
    under_way = file.string() + '\n';
    std::ifstream stream(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    read_bytes(text);
    const std::size_t step = std::max<std::size_t>(1, text.size() / longest_in_all);
    for (std::size_t size = 0; size < text.size(); size += step) read_bytes(text.substr(0, size));
}

std::vector<fs::path> files_of(const fs::path& name) {
    if (!fs::is_directory(name)) return {name};
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(name)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

void name_file(int number) {
    const char* const why = number == SIGALRM ? "takes too long over " : "dies of ";
    if (write(STDERR_FILENO, why, std::char_traits<char>::length(why)) < 0 ||
        write(STDERR_FILENO, under_way.data(), under_way.size()) < 0)
        _exit(2);
    signal(number, SIG_DFL);
    raise(number);
}

}  // namespace

int main(int argc, char** argv) {
    for (const int number : {SIGALRM, SIGABRT, SIGSEGV}) signal(number, name_file);
#ifndef PLUMB_SANITIZED  // whose shadow is larger than all memory
    const rlimit memory{1 << 30, 1 << 30};
    setrlimit(RLIMIT_AS, &memory);
#endif
    std::size_t count = 0;
    for (int i = 1; i < argc; ++i) {
        for (const fs::path& file : files_of(argv[i])) {
            read_file(file);
            ++count;
        }
    }
    std::printf("%zu files\n", count);
    return count > 0 ? 0 : 1;
}

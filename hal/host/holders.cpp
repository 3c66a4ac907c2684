// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/holders.hpp"

#include <dirent.h>
#include <pwd.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <vector>

namespace plumb::host {

namespace {

std::string folder_of(pid_t process) {
    return "/proc/" + std::to_string(process);
}

std::string user_name(uid_t user) {
    const passwd* const entry = getpwuid(user);
    return "user " + (entry != nullptr ? std::string(entry->pw_name) : std::to_string(user));
}

std::string program_of(pid_t process) {
    std::ifstream file(folder_of(process) + "/comm");
    std::string name;
    std::getline(file, name);
    for (char& c : name)
        if (c < ' ' || c > '~') c = '?';  // else it could write to the terminal
    return name;
}

bool there_is(pid_t process) {
    return process > 0 && access(folder_of(process).c_str(), F_OK) == 0;
}

std::vector<pid_t> processes() {
    std::vector<pid_t> found;
    DIR* const folder = opendir("/proc");
    if (folder == nullptr) return found;
    while (const dirent* const entry = readdir(folder))
        if (const pid_t process = std::atoi(entry->d_name); process > 0) found.push_back(process);
    closedir(folder);
    std::sort(found.begin(), found.end());
    return found;
}

// The process that has taken a lock by flock(), as the kernel lists it; 0 if it shows none.
pid_t taker_of_lock(const struct stat& file) {
    char place[64];
    std::snprintf(place, sizeof place, "%02x:%02x:%lu", major(file.st_dev), minor(file.st_dev),
                  static_cast<unsigned long>(file.st_ino));
    std::ifstream locks("/proc/locks");
    for (std::string line; std::getline(locks, line);) {
        std::istringstream words(line);
        std::string number, kind, mode, access, where;
        pid_t process = 0;
        if (words >> number >> kind >> mode >> access >> process >> where && kind == "FLOCK" &&
            where == place)
            return process;
    }
    return 0;
}

bool shows_a_lock(const std::string& details) {
    std::ifstream file(details);
    for (std::string line; std::getline(file, line);)
        if (line.rfind("lock:", 0) == 0 && line.find(" FLOCK ") != std::string::npos) return true;
    return false;
}

bool has_locked(pid_t process, const struct stat& file) {
    const std::string folder = folder_of(process);
    DIR* const entries = opendir((folder + "/fd").c_str());
    if (entries == nullptr) return false;
    bool found = false;
    while (const dirent* const entry = readdir(entries)) {
        struct stat state {};
        found = found || (stat((folder + "/fd/" + entry->d_name).c_str(), &state) == 0 &&
                          state.st_ino == file.st_ino && state.st_dev == file.st_dev &&
                          shows_a_lock(folder + "/fdinfo/" + entry->d_name));
    }
    closedir(entries);
    return found;
}

// A process that has inherited a lock holds it when the one that took it has closed the file, or has ended.
// Only root sees the files of other users.
pid_t holder_of(const struct stat& file) {
    const pid_t taker = taker_of_lock(file);
    if (there_is(taker) && has_locked(taker, file)) return taker;
    for (const pid_t process : processes())
        if (has_locked(process, file)) return process;
    return there_is(taker) ? taker : 0;
}

bool is_stopped(pid_t process) {
    std::ifstream file(folder_of(process) + "/stat");
    std::string line;
    std::getline(file, line);
    const std::size_t end = line.rfind(") ");
    return end != std::string::npos && (line[end + 2] == 'T' || line[end + 2] == 't');
}

bool has_attached(pid_t process, const std::string& segment) {
    std::ifstream maps(folder_of(process) + "/maps");
    for (std::string line; std::getline(maps, line);)
        if (line.find(segment) != std::string::npos) return true;
    return false;
}

std::string text_of(int key) {
    char text[16];
    std::snprintf(text, sizeof text, "%08x", static_cast<unsigned>(key));
    return text;
}

}  // namespace

std::string description_of(pid_t process) {
    struct stat state {};
    const bool known = stat(folder_of(process).c_str(), &state) == 0;
    return "process " + std::to_string(process) + ", " + program_of(process) +
           (known ? ", of " + user_name(state.st_uid) : "");
}

std::string who_holds(const std::string& path, int file) {
    struct stat state {};
    const pid_t holder = fstat(file, &state) == 0 ? holder_of(state) : 0;
    if (holder == 0)
        return "a process of another user holds " + path + ". 'sudo fuser -v " + path +
               "' shows it; end it, or wait";
    return description_of(holder) + " holds " + path + ". Wait for its end, or end it: kill " +
           std::to_string(holder);
}

std::string who_has_memory(int key) {
    const std::string text = text_of(key);
    std::string words = "shared memory 0x" + text;
    std::ifstream table("/proc/sysvipc/shm");
    std::string line;
    std::getline(table, line);  // the headings
    while (std::getline(table, line)) {
        std::istringstream numbers(line);
        long its_key = 0, id = 0, mode = 0, size = 0, attached = 0;
        pid_t maker = 0, last = 0;
        uid_t user = 0;
        if (!(numbers >> its_key >> id >> mode >> size >> maker >> last >> attached >> user) ||
            static_cast<int>(its_key) != key)
            continue;
        words += " of " + user_name(user);
        for (const pid_t process : {maker, last})
            if (there_is(process)) {
                words += ": " + description_of(process);
                break;
            }
    }
    return words + "; end its programs, or remove what they left: ipcrm -M 0x" + text;
}

std::string stopped_with_memory(int key) {
    std::string words;
    for (const pid_t process : processes())
        if (is_stopped(process) && has_attached(process, "/SYSV" + text_of(key)))
            words += (words.empty() ? "" : "; ") + description_of(process);
    return words;
}

}  // namespace plumb::host

// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/server.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <random>
#include <stdexcept>

#include "hal/host/leftovers.hpp"

namespace plumb::host {

namespace {

[[noreturn]] void fail(const std::string& what) {
    throw std::runtime_error(what + ": " + std::strerror(errno));
}

// Reads "COUNT " from `at` on and moves `at` behind it. Nothing when the text is not complete.
// Throws std::runtime_error when it is no number.
std::optional<std::size_t> take_number(const std::string& text, std::size_t& at) {
    constexpr std::size_t most_digits = 9;
    const std::size_t end = text.find(' ', at);
    const std::size_t last = end == std::string::npos ? text.size() : end;
    if (last - at > most_digits || !std::all_of(text.begin() + static_cast<std::ptrdiff_t>(at),
                                                text.begin() + static_cast<std::ptrdiff_t>(last),
                                                [](char c) { return c >= '0' && c <= '9'; }))
        throw std::runtime_error("not rtapi_app's protocol");
    if (end == std::string::npos) return std::nullopt;
    if (end == at) throw std::runtime_error("not rtapi_app's protocol");
    const std::size_t number = std::stoul(text.substr(at, end - at));
    at = end + 1;
    return number;
}

// The words of a request of rtapi_app's protocol, "COUNT " and then "LENGTH BYTES" for each; nothing when
// the text is not complete. Throws std::runtime_error when it is something else.
std::optional<std::vector<std::string>> words_of(const std::string& text) {
    std::size_t at = 0;
    const auto count = take_number(text, at);
    if (!count) return std::nullopt;
    std::vector<std::string> words;
    while (words.size() < *count) {
        const auto length = take_number(text, at);
        if (!length || text.size() - at < *length) return std::nullopt;
        words.push_back(text.substr(at, *length));
        at += *length;
    }
    return words;
}

// The process at the other end; user and process are -1 when the system does not say.
ucred process_at(int descriptor) {
    ucred peer{-1, static_cast<uid_t>(-1), static_cast<gid_t>(-1)};
    socklen_t size = sizeof peer;
    getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &peer, &size);
    return peer;
}

// Whether the other end is the same user's or root's, as is LinuxCNC's set-uid rtapi_app.
bool trusted(int descriptor) {
    const uid_t user = process_at(descriptor).uid;
    return user == geteuid() || user == 0;
}

// Whether nobody else can remove or rename what this process makes in the folder. In a user namespace its
// owner has no number to be known by.
bool is_safe(const std::string& folder) {
    struct stat state {};
    if (stat(folder.c_str(), &state) != 0 || (geteuid() == 0 && state.st_uid != 0)) return false;
    return (state.st_mode & (S_IWGRP | S_IWOTH)) == 0 || (state.st_mode & S_ISVTX) != 0;
}

// A new folder that is this user's alone, in TMPDIR or /tmp. The keeper knows of it before it is there: the
// host may be killed at any moment.
std::string make_folder() {
    const char* const asked_for = std::getenv("TMPDIR");
    // A socket's path must be short, and TMPDIR may not be there.
    const std::size_t most =
        sizeof sockaddr_un::sun_path - 1 - 1 - std::strlen(socket_name) - std::strlen(host_file_template) - 1;
    const bool good = asked_for != nullptr && *asked_for == '/' && std::strlen(asked_for) <= most;
    std::random_device random;
    for (const std::string base : {good ? asked_for : "/tmp", "/tmp"}) {
        if (!is_safe(base)) continue;
        for (int tries = 0; tries < 100; ++tries) {
            std::string name = std::string(host_file_beginning) + "......";
            for (char& letter : name)
                if (letter == '.') letter = "abcdefghijklmnopqrstuvwxyz0123456789"[random() % 36];
            const std::string folder = base + "/" + name;
            leftovers().set_folder(folder);
            if (mkdir(folder.c_str(), 0700) == 0) return folder;
            if (errno != EEXIST) break;
        }
    }
    leftovers().set_folder("");
    fail("cannot make a folder for the host's socket in /tmp");
}

}  // namespace

struct Server::Peer {
    Connection connection;
    int descriptor;
    bool is_client;       // the one that started this host
    bool busy = false;    // a request is under way
    bool finish = false;  // close as soon as all is sent
    bool gone = false;
    std::string received;
    std::string unsent;
    bool shown = false;  // the service has seen the request that waits
};

Server::Server(Service& service, int control_descriptor) : service_(service) {
    folder_ = make_folder();
    path_ = folder_ + "/" + socket_name;

    listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path_.c_str(), sizeof address.sun_path - 1);
    if (listener_ < 0 || bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
        listen(listener_, 64) != 0)
        fail("cannot listen on " + path_);
    admit_rtapi_app();

    if (control_descriptor >= 0) {
        fcntl(control_descriptor, F_SETFD, FD_CLOEXEC);
        fcntl(control_descriptor, F_SETFL, fcntl(control_descriptor, F_GETFL) | O_NONBLOCK);
        peers_.push_back({++last_, control_descriptor, true, false, false, false, {}, {}});
    }
}

Server::~Server() {
    for (Peer& peer : peers_) close(peer.descriptor);
    if (listener_ >= 0) close(listener_);
    remove_socket_folder(folder_);
}

// When root runs LinuxCNC's rtapi_app, it opens the socket with the rights of the user in RTAPI_UID. That
// user may connect, and is not answered (see trusted()); the folder stays root's, so that nobody else can put
// a socket of his own in the place of this one. Where there is no such user (EINVAL, in a user namespace)
// rtapi_app has root's rights.
void Server::admit_rtapi_app() const {
    const char* const user = geteuid() == 0 ? std::getenv("RTAPI_UID") : nullptr;
    if (user == nullptr) return;
    const auto owner = static_cast<uid_t>(std::atoi(user));
    if (lchown(path_.c_str(), owner, static_cast<gid_t>(-1)) != 0 && errno != EINVAL)
        fail("cannot give " + path_ + " to user " + user);
    if (chmod(folder_.c_str(), 0711) != 0) fail("cannot open " + folder_);
}

void Server::add_to(std::vector<pollfd>& waits) const {
    waits.push_back({listener_, POLLIN, 0});
    for (const Peer& peer : peers_)
        waits.push_back(
            {peer.descriptor, static_cast<short>(peer.unsent.empty() ? POLLIN : POLLIN | POLLOUT), 0});
}

void Server::accept_all() {
    for (;;) {
        const int descriptor = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (descriptor < 0) return;
        if (!trusted(descriptor)) {
            close(descriptor);
            continue;
        }
        peers_.push_back({++last_, descriptor, false, false, false, false, {}, {}});
    }
}

void Server::serve() {
    accept_all();
    // A service may close the connection that it answers, and a request may take a nested look at the
    // sockets.
    for (Peer& peer : peers_) {
        if (!peer.gone) receive(peer);
        if (!peer.gone) take_requests(peer);
        if (!peer.gone) transmit(peer);
    }
    for (auto peer = peers_.begin(); peer != peers_.end();) {
        if (!peer->gone) {
            ++peer;
            continue;
        }
        close(peer->descriptor);
        client_gone_ = client_gone_ || peer->is_client;
        const Connection connection = peer->connection;
        peer = peers_.erase(peer);
        service_.closed(connection);
    }
}

void Server::receive(Peer& peer) {
    char buffer[65536];
    for (;;) {
        const ssize_t count = recv(peer.descriptor, buffer, sizeof buffer, MSG_DONTWAIT);
        if (count > 0) {
            peer.received.append(buffer, static_cast<std::size_t>(count));
            continue;
        }
        if (count < 0 && errno == EINTR) continue;
        if (count == 0 || (errno != EAGAIN && errno != EWOULDBLOCK)) peer.gone = true;
        return;
    }
}

void Server::take_requests(Peer& peer) {
    if (!peer.received.empty() && peer.received[0] >= '0' && peer.received[0] <= '9' && !peer.is_client) {
        if (!take_text_request(peer)) peer.gone = true;
        return;
    }
    while (!peer.finish && !(peer.busy && peer.shown)) {
        const std::size_t end = peer.received.find('\n');
        if (end == std::string::npos) return;
        const std::string line = peer.received.substr(0, end);
        if (peer.busy) {
            peer.shown = true;
            service_.control_request_waits(line);
        } else {
            peer.received.erase(0, end + 1);
            peer.busy = true;
            service_.control_request(peer.connection, line);
        }
    }
}

bool Server::has_requests() const {
    return std::any_of(peers_.begin(), peers_.end(), [](const Peer& peer) {
        return !peer.busy && !peer.finish && !peer.gone && peer.received.find('\n') != std::string::npos;
    });
}

bool Server::take_text_request(Peer& peer) {
    try {
        const auto words = words_of(peer.received);
        if (!words || peer.finish) return true;
        peer.finish = true;
        peer.unsent = std::to_string(service_.rtapi_command(*words, process_at(peer.descriptor).pid)) + " ";
        return true;
    } catch (const std::runtime_error&) {
        return false;
    }
}

void Server::transmit(Peer& peer) {
    while (!peer.unsent.empty()) {
        const ssize_t count =
            ::send(peer.descriptor, peer.unsent.data(), peer.unsent.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
        if (count > 0) {
            peer.unsent.erase(0, static_cast<std::size_t>(count));
            continue;
        }
        if (count < 0 && errno == EINTR) continue;
        if (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK) peer.gone = true;
        return;
    }
    if (peer.finish) peer.gone = true;
}

Server::Peer* Server::find(Connection connection) {
    for (Peer& peer : peers_)
        if (peer.connection == connection) return &peer;
    return nullptr;
}

void Server::send(Connection to, const std::string& line) {
    Peer* const peer = find(to);
    if (peer == nullptr || peer->gone) return;
    peer->unsent += line + "\n";
    transmit(*peer);
}

void Server::answer(Connection to, const std::string& line) {
    send(to, line);
    if (Peer* const peer = find(to)) {
        peer->busy = false;
        peer->shown = false;
    }
}

void Server::flush() {
    for (int tries = 0; tries < 100; ++tries) {
        bool all_sent = true;
        for (Peer& peer : peers_) {
            if (!peer.gone) transmit(peer);
            all_sent = all_sent && (peer.gone || peer.unsent.empty());
        }
        if (all_sent) return;
        poll(nullptr, 0, 10);
    }
}

}  // namespace plumb::host

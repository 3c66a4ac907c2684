// SPDX-License-Identifier: GPL-2.0-or-later
// All bytes that a program of the user may send to the socket of the host: requests in both protocols, and
// anything else.
#include "hal/host/server.hpp"

#include "tests/readers/reader.hpp"
#include "tests/readers/repeated.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "hal/host/messages.hpp"
#include "hal/host/request.hpp"

namespace plumb::readers {
namespace {

constexpr std::size_t most = 1 << 20;  // bytes of a request

constexpr std::size_t most_lines = 1 << 12;  // for the sake of time

// Answers each request at once.
class Echo final : public host::Server::Service {
public:
    host::Server* server = nullptr;
    std::size_t taken = 0, closed_ones = 0;

    host::RtapiAnswer rtapi_command(const std::vector<std::string>& words, pid_t) override {
        std::size_t bytes = 0;
        for (const std::string& word : words) bytes += word.size();
        demand(bytes <= most, "a command has a limit");
        ++taken;
        return {0, "taken"};
    }
    void control_request(host::Server::Connection from, const std::string& line) override {
        demand(line.size() <= most, "a request has a limit");
        demand(line.find('\n') == std::string::npos, "a request is a line");
        takes<std::runtime_error>([&] { host::Request request(line); });
        answer(from);
    }
    void request_too_long(host::Server::Connection from) override { answer(from); }
    void control_request_waits(const std::string&) override {}
    void closed(host::Server::Connection) override { ++closed_ones; }

private:
    void answer(host::Server::Connection to) {
        ++taken;
        server->answer(to, "{}");
    }
};

int connection_to(const std::string& path) {
    const int peer = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    demand(connect(peer, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0, "the server listens");
    return peer;
}

// All that the server has sent; nothing when it has closed the connection.
bool receive(int peer, std::size_t& lines) {
    char buffer[65536];
    for (;;) {
        const ssize_t count = recv(peer, buffer, sizeof buffer, MSG_DONTWAIT);
        if (count == 0) return false;
        if (count < 0) return errno == EAGAIN || errno == EWOULDBLOCK;
        lines += static_cast<std::size_t>(std::count(buffer, buffer + count, '\n'));
    }
}

void attend(host::Server& server) {
    std::vector<pollfd> waits;
    server.add_to(waits);
    poll(waits.data(), waits.size(), 0);
    server.serve(waits);
}

void read(std::string_view bytes) {
    const std::string text = repeated(bytes, 2 << 20);
    const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
    if (lines > most_lines) return;
    host::set_message_sink([](std::string_view, bool) { return true; });
    Echo echo;
    host::Server server(echo, -1);
    echo.server = &server;
    const int peer = connection_to(server.path());
    std::size_t sent = 0, answers = 0;
    bool open = true;
    // A round for each piece that it takes, and for each 64 requests, is enough.
    const std::size_t rounds = 64 + text.size() / 4096 + lines / 32;
    for (std::size_t round = 0; round < rounds && open; ++round) {
        const ssize_t count =
            ::send(peer, text.data() + sent, text.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (count > 0) sent += static_cast<std::size_t>(count);
        attend(server);
        open = receive(peer, answers);
    }
    if (open) {
        demand(sent == text.size(), "the server takes all that is sent");
        if (text.empty() || text[0] < '0' || text[0] > '9')
            demand(answers == lines && echo.taken == lines, "each request is answered");
    }
    close(peer);
    attend(server);
    demand(echo.closed_ones == 1, "the server learns that a connection is closed");
}

const Reader reader{"server", read};

}  // namespace
}  // namespace plumb::readers

// SPDX-License-Identifier: GPL-2.0-or-later
// The requests of rtapi_app of LinuxCNC 2.9 and 2.10: as bytes, and to a host.
#include "hal/host/rtapi_protocol.hpp"

#include "tests/support/bench.hpp"

#include <gmock/gmock.h>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <stdexcept>

namespace plumb {
namespace {

using host::frame_of;
using host::words_of_frame;
using host::words_of_text;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Optional;

std::string bytes(std::initializer_list<int> all) {
    return {all.begin(), all.end()};
}

std::string number(std::size_t value) {
    return bytes({static_cast<int>(value & 0xff), static_cast<int>(value >> 8)});
}

// A request of 2.10 with these words.
std::string frame(const std::vector<std::string>& words) {
    std::string content = number(words.size());
    for (const std::string& word : words) content += number(word.size()) + word;
    return number(content.size() + 2) + content;
}

TEST(RtapiProtocol, AFrameHasItsWords) {
    EXPECT_THAT(words_of_frame(frame({"load", "not"})), Optional(ElementsAre("load", "not")));
    EXPECT_THAT(words_of_frame(frame({"load", "", std::string(300, 'x')})),
                Optional(ElementsAre("load", "", std::string(300, 'x'))));
    EXPECT_THAT(words_of_frame(frame({})), Optional(ElementsAre()));
}

TEST(RtapiProtocol, EachBeginningOfAFrameIsIncomplete) {
    const std::string whole = frame({"load", "not", "names=a,b"});
    for (std::size_t size = 0; size < whole.size(); ++size)
        EXPECT_EQ(words_of_frame(whole.substr(0, size)), std::nullopt) << size;
}

TEST(RtapiProtocol, AFrameThatContradictsItselfIsRefused) {
    EXPECT_THROW(words_of_frame(bytes({3, 0, 0})), std::runtime_error);                // no room for a count
    EXPECT_THROW(words_of_frame(bytes({4, 0, 1, 0})), std::runtime_error);             // no length
    EXPECT_THROW(words_of_frame(bytes({7, 0, 1, 0, 2, 0, 'a'})), std::runtime_error);  // a word too short
    EXPECT_THROW(words_of_frame(bytes({8, 0, 1, 0, 1, 0, 'a', 'b'})), std::runtime_error);  // bytes are left
    EXPECT_THROW(words_of_frame(bytes({4, 0, 255, 255})), std::runtime_error);
}

TEST(RtapiProtocol, AnAnswerIsAFrameWithAnErrnoAndOutput) {
    EXPECT_EQ(frame_of({0}), bytes({8, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(frame_of({-22}), bytes({8, 0, 0xea, 0xff, 0xff, 0xff, 0, 0}));
    EXPECT_EQ(frame_of({1, "No realtime"}), bytes({19, 0, 1, 0, 0, 0, 11, 0}) + "No realtime");
    const std::string longest = frame_of({0, std::string(100'000, 'x')});
    EXPECT_EQ(longest.size(), 65535u);
    EXPECT_EQ(longest.substr(0, 2), bytes({0xff, 0xff}));
}

TEST(RtapiProtocol, TextHasItsWords) {
    EXPECT_THAT(words_of_text("2 4 load3 not"), Optional(ElementsAre("load", "not")));
    EXPECT_EQ(words_of_text("2 4 load3 no"), std::nullopt);
    EXPECT_THROW(words_of_text("2 4 load3x"), std::runtime_error);
    EXPECT_THROW(words_of_text("1 999999 " + std::string(1 << 18, 'x')), std::runtime_error);
    EXPECT_EQ(host::text_of({-22}), "-22 ");
}

// A host's answer to a request of rtapi_app of LinuxCNC 2.10.
std::string answer_to(client::Client& host, const std::string& request) {
    const int peer = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    host.socket().copy(address.sun_path + 1, sizeof address.sun_path - 2);
    EXPECT_EQ(connect(peer, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(send(peer, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
    std::string answer;
    char buffer[4096];
    for (ssize_t count; (count = recv(peer, buffer, sizeof buffer, 0)) > 0;)
        answer.append(buffer, static_cast<std::size_t>(count));
    close(peer);
    return answer;
}

TEST(RtapiProtocol, AHostServesLinuxCnc210) {
    client::Start start;
    start.namespaces = false;  // the abstract socket is this process's too
    client::Client host(start);
    const std::vector<std::string> outputs{"of-frame.out"};
    EXPECT_EQ(answer_to(host, frame({"ping"})), frame_of({1}));
    EXPECT_EQ(answer_to(host, frame({"start"})), frame_of({0}));
    EXPECT_EQ(answer_to(host, frame({"ping"})), frame_of({0}));
    EXPECT_EQ(answer_to(host, frame({"check_rt"})), frame_of({1, "No realtime"}));
    EXPECT_EQ(answer_to(host, frame({"load", "not", "names=of-frame"})), frame_of({0}));
    EXPECT_EQ(host.read(outputs).size(), 1u);
    EXPECT_EQ(answer_to(host, frame({"unload", "not"})), frame_of({0}));
    EXPECT_THROW(host.read(outputs), std::runtime_error);
    EXPECT_EQ(answer_to(host, frame({"debug", "5"})), frame_of({0}));
    EXPECT_EQ(answer_to(host, frame({"debug", "6"})), frame_of({-22}));
    EXPECT_EQ(answer_to(host, frame({"debug", ""})), frame_of({-22}));
    EXPECT_EQ(answer_to(host, frame({"unknown"})), frame_of({-1}));
    EXPECT_EQ(answer_to(host, bytes({3, 0, 0})), "");  // refused, and the host lives
    EXPECT_EQ(answer_to(host, frame({"ping"})), frame_of({0}));
}

}  // namespace
}  // namespace plumb

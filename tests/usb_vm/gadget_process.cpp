// SPDX-License-Identifier: Apache-2.0
#include "tests/usb_vm/gadget_process.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace fanlight::test {

namespace {

struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe can be made");
    read_end = ends[0];
    write_end = ends[1];
  }
  int read_end = -1;
  int write_end = -1;
};

}  // namespace

GadgetProcess::GadgetProcess(const std::string& program, const std::vector<std::string>& options) {
  const Pipe orders;
  const Pipe answers;
  std::vector<char*> arguments{const_cast<char*>(program.c_str())};
  for (const std::string& option : options) arguments.push_back(const_cast<char*>(option.c_str()));
  arguments.push_back(nullptr);
  id_ = fork();
  if (id_ == 0) {
    dup2(orders.read_end, STDIN_FILENO);
    dup2(answers.write_end, STDOUT_FILENO);
    execv(program.c_str(), arguments.data());
    _exit(127);
  }
  close(orders.read_end);
  close(answers.write_end);
  orders_ = fdopen(orders.write_end, "w");
  answers_ = fdopen(answers.read_end, "r");
  plugged_ns_ = std::stoll(answer());
}

GadgetProcess::~GadgetProcess() {
  std::fclose(orders_);
  waitpid(id_, nullptr, 0);
  std::fclose(answers_);
}

std::string GadgetProcess::ask(const std::string& line) {
  std::fputs((line + "\n").c_str(), orders_);
  std::fflush(orders_);
  return answer();
}

std::string GadgetProcess::answer() {
  std::array<char, 512> line{};
  if (std::fgets(line.data(), line.size(), answers_) == nullptr || line[0] == '?')
    throw std::runtime_error("the gadget probe did not answer");
  return line.data();
}

}  // namespace fanlight::test

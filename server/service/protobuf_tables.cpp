// SPDX-License-Identifier: Apache-2.0
#include "server/service/protobuf_tables.hpp"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <memory>
#include <string>

#include "proto/fanlight.pb.h"

namespace fanlight {

void build_protobuf_tables() {
  namespace pb = google::protobuf;
  const pb::FileDescriptor& file = *v1::ServerMessage::descriptor()->file();
  for (int index = 0; index < file.message_type_count(); ++index) {
    const pb::Message* const prototype =
        pb::MessageFactory::generated_factory()->GetPrototype(file.message_type(index));
    const std::unique_ptr<pb::Message> message(prototype->New());
    std::string text;
    // What they say of an empty message is of no interest: the tables that they need exist then.
    (void)pb::util::MessageToJsonString(*message, &text);
    (void)pb::util::JsonStringToMessage("{}", message.get());
  }
}

}  // namespace fanlight

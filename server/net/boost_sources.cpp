// SPDX-License-Identifier: Apache-2.0
// Asio, Beast and URL, compiled once. The other sources include their declarations only. Since 1.83 URL is a
// library.
#include <boost/asio/impl/src.hpp>
#include <boost/asio/ssl/impl/src.hpp>
#include <boost/beast/src.hpp>
#include <boost/version.hpp>
#if BOOST_VERSION < 108300
#include <boost/url/src.hpp>
#endif

# SPDX-License-Identifier: Apache-2.0
class Failure(Exception):
    """Ends the comparison. Its message is one sentence for the user: the problem, and what was expected."""

"""How `make notebooks` starts kernels: over files, as two that start at once may choose the same TCP port."""

import os
from tempfile import TemporaryDirectory
from uuid import uuid4

from jupyter_client.manager import KernelManager
from nbclient import NotebookClient

create = NotebookClient.create_kernel_manager
sockets = TemporaryDirectory(prefix="kernels-")


def create_over_files(self: NotebookClient) -> KernelManager:
    manager = create(self)
    manager.transport = "ipc"
    manager.ip = f"{sockets.name}/{uuid4().hex}"
    return manager


if os.name == "posix":
    NotebookClient.create_kernel_manager = create_over_files

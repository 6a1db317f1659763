"""A headframe-server of the build, for tests in Python."""

import subprocess


class Server:
    def __init__(self, programs, data, *options, http="127.0.0.1:0"):
        self.programs, self.data = programs, data
        self.process = subprocess.Popen([programs / "headframe-server", "--data", data, "--listen", "127.0.0.1:0", "--http", http,
                                         *options], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.printed = ""
        for line in self.process.stdout:
            self.printed += line
            if "ready" in line:
                break
        self.address, self.http, self.fingerprint = (self.after(what) for what in ("robots on ", "http on ", "fingerprint: "))

    def after(self, words):
        return self.printed.partition(words)[2].partition("\n")[0].partition(",")[0]

    @property
    def token_file(self):
        return str(self.data / "operator.token")

    def play(self, robot, drive, *options):
        """A whole drive, acknowledged."""
        subprocess.run([self.programs / "headframe-replay", "--server", self.address, "--robot", robot, "--fast", *options, drive],
                       check=True, stdout=subprocess.DEVNULL, timeout=300)

    def stop(self):
        self.process.terminate()
        self.process.wait()
        self.process.stdout.close()
